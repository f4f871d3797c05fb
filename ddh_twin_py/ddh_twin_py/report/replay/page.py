"""The report of a replay: the twin beside what was measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.charts import Chart, Trace, charts
from ddh_twin_py.report.page.decimate import MOST_POINTS
from ddh_twin_py.report.replay.agreement import (
    COMPONENTS,
    FLOOR,
    INPUTS,
    SETTLING,
    Agreement,
    beyond,
    component_values,
    free_values,
    level,
    measured_values,
    signal_row,
)
from ddh_twin_py.report.replay.smoothed import NOTE as SMOOTHED_NOTE
from ddh_twin_py.report.replay.smoothed import smoothed_charts, smoothed_json, smoothed_table
from ddh_twin_py.report.times import going_on, starts
from ddh_twin_py.report.units import ZERO_CELSIUS, celsius, duration, in_unit, number, shown, words
from ddh_twin_py.telemetry.clocks.clock import PUT_BACK
from ddh_twin_py.telemetry.recording import SLIGHT
from ddh_twin_py.telemetry.signals import signal_named
from ddh_twin_py.twin.hydraulic_model import UNSEEN

if TYPE_CHECKING:
    from ddh_twin_py.estimation.replay_result import ReplayResult
    from ddh_twin_py.telemetry.recording import Finding, Recording

_CHART_ORDER = (
    "pressure_piston_side", "pressure_rod_side", "torque", "current", "electrical_power", "voltage", "speed",
    "rod_velocity", "rod_position",
)
_MOST_FINDINGS = 60
DATA_SPLIT = (
    "Nothing was fitted: the twin uses the rig file as it is, and the whole recording is test data for the free run. "
    "The fusion takes in the temperature sensors that it is compared with, so its RMS is no test of prediction"
)


def replay_document(
    result: ReplayResult, agreement: Agreement, how: str = "in one process", extra: Sequence[tuple[str, str]] = (),
) -> doc.Document:
    """The page of a replay.

    Args:
        how: by which path the twin's values came to be. extra: further rows of the end matter.
    """
    recording = result.recording
    rig = recording.rig
    title = (rig.rig_id if rig is not None else result.rig.rig_id) + ", " + recording.path.rstrip("/").split("/")[-1]
    rows = [("Recording", f"{recording.path}, {duration(recording.duration)}, "
             f"{datetime.fromtimestamp(recording.epoch_ns * 1e-9, UTC):%Y-%m-%d %H:%M:%S} UTC, "
             f"{agreement.intervals} intervals"), ("Way of the data", how)]
    if result.seconds:
        parts = ", ".join(f"{words(k)} {v:.2f} s" for k, v in result.seconds.items())
        rows.append(("Computing time", f"{sum(result.seconds.values()):.2f} s ({parts})"))
    page = doc.Document(
        kind="Replay", title=title, verdict=agreement.verdict, level=agreement.level,
        end=doc.EndMatter(_data_split(agreement), result.rig.file, assumptions(result), (*rows, *extra)),
    )
    domain = tuple(going_on(result.time)[[0, -1]]) if result.time.size else (0.0, 1.0)
    page.add("At a glance", doc.figures(_key_figures(result, agreement)))
    if recording.findings:
        page.add("What was found in the input", findings_table(recording))
    page.add(
        "Temperatures", _temperature_table(agreement), _temperature_note(agreement),
        charts(_temperature_charts(result), domain), _node_table(agreement),
    )
    if result.smoothed_row.size:
        page.add("Smoothed temperatures", doc.note(SMOOTHED_NOTE), smoothed_table(result),
                 charts(smoothed_charts(result, going_on(result.time)), domain))
    page.add("Drive and hydraulics", _signal_table(agreement), charts(_signal_charts(result), domain))
    page.add("Losses", *_losses(result, agreement, domain))
    return page


def replay_json(
    result: ReplayResult, agreement: Agreement, how: str = "in one process", extra: Mapping | None = None
) -> dict:
    """The machine-readable twin of the page: every number of its tables, and its end matter."""
    recording = result.recording
    return {
        "report": "replay",
        "recording": {
            "path": recording.path, "epoch_ns": recording.epoch_ns, "duration_s": recording.duration,
            "namespace": recording.namespace, "rig": asdict(recording.rig) if recording.rig is not None else None,
        },
        **agreement.as_json(),
        "smoothed": smoothed_json(result),
        "findings": [asdict(finding) for finding in recording.findings],
        **(extra or {}),
        "end_matter": {
            **end_matter_json(result), "data_split": _data_split(agreement), "way_of_the_data": how,
            "computing_time_s": dict(result.seconds),
        },
    }


def end_matter_json(result: ReplayResult) -> dict:
    """What the numbers of a replay rest on."""
    return {
        **doc.EndMatter(f"{DATA_SPLIT}.", result.rig.file, assumptions(result)).as_json(), "rig_id": result.rig.rig_id,
    }


def assumptions(result: ReplayResult) -> list[str]:
    """What was taken for granted."""
    recording, step = result.recording, float(np.median(np.diff(result.time))) if result.time.size > 1 else 0.0
    taken = [
        f"Values are means over intervals of {step * 1e3:.0f} ms; noise is that of one sample, from the rig file, so a "
        "model that is right can lie below 1 times noise.",
        f"Agreement means an RMS within {FLOOR:g} times noise, the floor of the interface for a rig without "
        "commissioning data.",
        "The free run is given speed command, payload and ambient; at each standstill its rod is put back to the "
        "measured position, since position integrates.",
        "The soft sensor is driven by measured speed, pressures, rod motion and current; these are its inputs and are "
        "not compared with it.",
    ]
    spec = result.rig.sensors.get("temperature")
    if spec is not None and result.sensors:
        taken.append(
            "Temperature sensors read their node through a lag of "
            f"{result.rig['sensors.temperature.time_constant']:g} s and may have a zero error "
            f"of {spec.offset_tolerance:g} K (one sigma) that counts as difference here."
        )
    if (np.diff(result.time) <= 0.0).any():
        taken.append(f"The clock of the recording jumped back; where it did by more than {PUT_BACK:g} s everything starts anew, else the "
                     "unit is as warm as it was. The charts go on.")
    if recording.rig is None or not np.isfinite(recording.rig.payload_mass):
        payload = result.rig["load.payload_mass"]
        taken.append(f"Payload {payload:g} kg is the rig file's: the recording tells none that can be used.")
    if "ambient" not in recording.temperatures:
        taken.append(f"Ambient {result.rig['ambient']:g} °C is the rig file's: the recording has no sensor for it.")
    return taken


def findings_table(recording: Recording) -> doc.Html:
    """What is wrong with the input: file, topic and value in each message; worst first, what strikes few samples folded away."""
    order = {"error": 0, "warning": 1, "info": 2}
    slight = recording.slight_findings()
    loud = sorted((f for f in recording.findings if f not in slight), key=lambda f: order.get(f.severity, 3))
    shown = _findings_rows(loud) if loud else ""
    if slight:
        each = "each strikes" if len(slight) > 1 else "it strikes"
        said = f"{len(slight)} slight warning{'s' * (len(slight) > 1)}: {each} at most {100.0 * SLIGHT:g} % of a topic's samples"
        shown += doc.details(said, _findings_rows(slight))
    return doc.Html(shown)


def _findings_rows(findings: Sequence[Finding]) -> str:
    sign = {"error": "poor", "warning": "fair", "info": "none"}
    rows = [(doc.mark(sign.get(f.severity, "none"), f.severity), f.message, str(f.count)) for f in findings[:_MOST_FINDINGS]]
    columns = (
        doc.Column("Level", number=False), doc.Column("What, where and which value", number=False), doc.Column("Times")
    )
    table = doc.table(columns, rows)
    more = len(findings) - _MOST_FINDINGS
    return table + doc.note(f"{more} more are in the JSON file.") if more > 0 else table


def _data_split(agreement: Agreement) -> str:
    left = [t for t in agreement.temperatures if t.rms_left_out is not None]
    if left:
        return f"{DATA_SPLIT}; 'left out' is: {len(left)} further runs, each with one sensor kept from the fusion."
    return DATA_SPLIT + "."


def _key_figures(result: ReplayResult, agreement: Agreement) -> list[doc.Figure]:
    rig = result.recording.rig
    load = f"{rig.oil_grade}, payload {rig.payload_mass:g} kg" if rig and np.isfinite(rig.payload_mass) else "payload not known"
    figures = [
        doc.Figure("Rig", rig.rig_id if rig else result.rig.rig_id, load if rig else "not named in the recording"),
        doc.Figure("Recording", duration(agreement.duration), result.recording.path),
    ]
    if agreement.counted:
        name, rms, _, times = agreement.counted[0]
        within = sum(row[3] <= FLOOR for row in agreement.counted)
        figures += [
            doc.Figure("Within the noise floor", f"{within} of {len(agreement.counted)}",
                       f"free run, {FLOOR:g} × noise"),
            doc.Figure("Furthest off", f"{beyond(times) if times > FLOOR else number(times, 1)} × noise", f"{name}, RMS {rms}"),
        ]
    if agreement.temperatures:
        worst = max(agreement.temperatures, key=lambda t: t.rms_predicted)
        figures.append(doc.Figure("Predicted temperatures", f"{number(worst.rms_predicted, 2)} K",
                                  f"largest RMS, {words(worst.sensor)}"))
    if agreement.nodes:
        hottest = max(agreement.nodes, key=lambda n: n.fused)
        lagging = [f"; its sensor, which lags, would read {celsius(t.fused, 1)}" for t in agreement.temperatures if t.node == hottest.node]
        figures.append(doc.Figure("Warmest at the end", f"{celsius(hottest.fused, 1)} °C",
                                  f"{words(hottest.node)} itself, ± {number(hottest.fused_std, 2)} K{''.join(lagging)}"))
    losses, electrical = sum(x.soft for x in agreement.losses), agreement.energy["electrical_power_soft_sensor"]
    found = [
        f"{count} {severity}{'s' * (count > 1)}" for severity in ("error", "warning")
        if (count := sum(f.severity == severity for f in result.recording.findings))
    ]
    return [
        *figures,
        doc.Figure("Mean losses", f"{losses:.0f} W", f"of {electrical:.0f} W electrical"),
        doc.Figure("Input", ", ".join(found), "see below") if found
        else doc.Figure("Input", "sound", "nothing found"),
    ]


def _temperature_table(agreement: Agreement) -> doc.Html:
    left_out = any(t.rms_left_out is not None for t in agreement.temperatures)
    if not agreement.temperatures:
        return doc.paragraph("No temperature sensor was recorded; the fusion rests on the models alone.")
    columns = [
        doc.Column("Sensor", number=False), doc.Column("Measured", "°C, last"), doc.Column("Predicted", "°C, free run"),
        doc.Column("Fused ± σ", "°C, as read"), doc.Column("RMS predicted", "K"),
        doc.Column("RMS fused", f"K, uses sensor, from {SETTLING:g} s"),
        *((doc.Column("RMS left out", "K, sensor not used"),) if left_out else ()),
        doc.Column("Noise", "K"), doc.Column("Predicted", "in noise", number=False),
        doc.Column("Readings"), doc.Column("Refused", "by the filter"),
    ]
    rows = []
    for t in agreement.temperatures:
        times = t.predicted_in_noise
        rows.append((
            words(t.sensor), celsius(t.measured), celsius(t.predicted),
            f"{celsius(t.fused)} ± {number(t.fused_std, 2)}", number(t.rms_predicted, 3),
            number(t.rms_fused, 3) + ("" if t.used else " (not used)"),
            *((f"{number(t.rms_left_out, 3)} (σ {number(t.std_left_out, 2)})",) if left_out else ()),
            number(t.noise, 2), doc.mark(level(times), f"{number(times, 2)} ×"), str(t.samples), str(t.refused),
        ))
    return doc.table(columns, rows)


def _temperature_note(agreement: Agreement) -> doc.Html:
    if not agreement.temperatures:
        return doc.Html("")
    return doc.note(
        "This table, and both lines of a chart, are seen through the sensor's lag: a place that cools is colder than that by now, see all "
        "thermal nodes at the end. Apart from what the rig file knows of it, the fused estimate leaves out the "
        "sensor's own zero error, which the filter estimates beside it. RMS predicted is over all readings of the recording, RMS fused "
        f"over those from {SETTLING:g} s after each start, by when the filter has found the temperatures (over all readings: largest "
        f"{number(max(t.rms_fused_whole for t in agreement.temperatures), 2)} K). Until then its band does not stretch the axis. "
        f"Below each chart: sensor less estimate; the grey band is {FLOOR:g} times its noise."
    )


def _node_table(agreement: Agreement) -> doc.Html:
    rows = [
        (words(n.node), celsius(n.predicted), celsius(n.fused), number(n.fused_std, 2), words(n.sensor) or "none")
        for n in agreement.nodes
    ]
    columns = (
        doc.Column("Thermal node", number=False), doc.Column("Predicted", "°C, free run"), doc.Column("Fused", "°C"),
        doc.Column("σ", "K"), doc.Column("Sensor", number=False),
    )
    return doc.details("All thermal nodes at the end", doc.table(columns, rows))


def _signal_table(agreement: Agreement) -> doc.Html:
    columns = (
        doc.Column("Signal", number=False), doc.Column("Range measured"), doc.Column("RMS free run"),
        doc.Column("Free run", "in noise", number=False), doc.Column("RMS soft sensor"),
        doc.Column("Soft sensor", "in noise", number=False), doc.Column("Noise", "one sample"),
        doc.Column("Largest, free run", "at"),
    )
    rows = []
    for s in agreement.signals:
        unit = shown(s.unit)
        low, high = (number(v * unit.factor, max(0, unit.digits - 1)) for v in (s.lowest, s.highest))
        soft = (
            (doc.mark("none", "input"), "") if s.rms_soft is None
            else (in_unit(s.rms_soft, s.unit), doc.mark(level(s.soft_in_noise), f"{number(s.soft_in_noise, 2)} ×"))
        )
        rows.append((
            signal_row(s.name), f"{low} … {high} {unit.unit}", in_unit(s.rms_free, s.unit),
            doc.mark(level(s.free_in_noise), f"{number(s.free_in_noise, 2)} ×"), *soft, in_unit(s.noise, s.unit),
            f"{in_unit(s.largest_free, s.unit)} at {number(s.largest_at, 1)} s",
        ))
    return doc.Html(
        doc.table(columns, rows)
        + doc.note("RMS of interval means against measurement, the free run where the samples of an interval lie, "
                   f"from {UNSEEN:g} s after each start: what moved before it is not known. Torque is current times a constant and is not "
                   f"counted twice. Below each chart: measured less twin; the grey band is {FLOOR:g} times noise.")
    )


def _temperature_charts(result: ReplayResult) -> list[Chart]:
    several = []
    for name, c in result.sensors.items():
        fused = "fused" if c.used else "fused, sensor not used"
        time = going_on(c.time)
        several.append(Chart(
            words(name).capitalize(), "°C", time,
            (
                Trace("measured", "measured", c.measured - ZERO_CELSIUS, dots=True),
                Trace(f"{fused} ± 2σ", "fused", c.fused - ZERO_CELSIUS, spread=2.0 * c.fused_std),
                Trace("predicted", "predicted", c.predicted - ZERO_CELSIUS, dash=True),
            ),
            height=190, differences=((0, 1), (0, 2)), floor=FLOOR * c.noise,
            unsettled=[(time[i], time[i] + SETTLING) for i in starts(c.time)],
        ))
    return several


def _signal_charts(result: ReplayResult) -> list[Chart]:
    several = []
    for name in _CHART_ORDER:
        signal = signal_named(name)
        measured = measured_values(result, signal)
        if not np.isfinite(measured).any():
            continue
        unit = shown(signal.unit)
        traces = [Trace("measured", "measured", measured * unit.factor)]
        if name not in INPUTS:
            traces.append(Trace("soft sensor", "soft", result.soft[name] * unit.factor))
        traces.append(Trace("free run", "predicted", free_values(result, signal) * unit.factor))
        wide = name.startswith("pressure")
        differences = tuple((0, i) for i in range(1, len(traces)))
        noise = result.rig.sensors[signal.noise_key].noise * unit.factor
        several.append(Chart(
            words(name).capitalize(), unit.unit, going_on(result.time), traces, digits=unit.digits,
            wide=wide, height=210 if wide else 180, differences=differences, floor=FLOOR * noise,
        ))
    return several


def _losses(result: ReplayResult, agreement: Agreement, domain: tuple[float, float]) -> list[str]:
    values = {name: component_values(result.soft, fields) for name, fields in COMPONENTS.items()}
    traces = [
        Trace(name, f"c{i}", loss, shown=bool(np.any(loss > 0.5))) for i, (name, loss) in enumerate(values.items(), 1)
    ]
    chart = Chart(
        "Losses by component, soft sensor", "W", going_on(result.time), traces, digits=1, height=260, wide=True,
        zero=True, most=MOST_POINTS // 2,
    )
    return [
        doc.paragraph("Mean power that each component turns into heat."),
        doc.legend((("soft", "soft sensor, from measured pressures, speed and current"), ("predicted", "free run"))),
        doc.bars([(x.component, (("soft", x.soft), ("predicted", x.free))) for x in agreement.losses], "W"),
        charts([chart], domain),
    ]
