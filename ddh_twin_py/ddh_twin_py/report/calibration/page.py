"""The report of a calibration: what the recordings say about the rig, and how well the fit predicts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.report.calibration.groups import BARELY, GROUPS, WELL, SignalFit, group_of, grouped
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.charts import Chart, Trace, charts
from ddh_twin_py.report.page.decimate import mean_and_ends
from ddh_twin_py.report.replay.agreement import FLOOR, level
from ddh_twin_py.report.units import duration, in_file, number, shown, words

if TYPE_CHECKING:
    from ddh_twin_py.estimation.fitting.calibration import Calibration
    from ddh_twin_py.estimation.fitting.experiment import Experiment

_MARK = {"informed": "good", "partly informed": "fair", "stays at prior": "none", "refused": "poor"}
_ROLE = {"informed": "c1", "partly informed": "c2", "stays at prior": "c3", "refused": "c4"}
_MEANING = {
    "informed": f"standard deviation below {100 * WELL:.0f} % of the prior's",
    "partly informed": f"{100 * WELL:.0f} to {100 * BARELY:.0f} %",
    "stays at prior": f"above {100 * BARELY:.0f} %: the recordings say next to nothing",
    "refused": "asked for, but the recordings cannot identify it; the rig file keeps its prior",
}
_RMS = (
    "RMS of the free run over the noise of one sample. ddh-twin replay gives other numbers: it compares means over 50 ms, without the "
    "first 5 s; here each sample counts, and temperatures begin as their first minute tells."
)
_MOST_DOTS, _SPANS = 1500, 400
_CHARTS = (
    f"Charts: a dot is a sample; where there are more than {_MOST_DOTS}, the line is the mean over a {_SPANS}th of the time and the band "
    "around it goes from the lowest to the highest sample there. Blue band: "
    f"{FLOOR:g} times the noise of one sample of the sensor, by the rig file, which the RMS should stay within; single samples of plain "
    "noise leave it."
)


def assumptions(fit: Calibration) -> list[str]:
    """What was taken for granted."""
    held = ["All parameters that were not asked for are held exact, at the rig file's values; the standard deviations do not "
            "count their tolerance."] if fit.asked else []
    return [
        *held,
        "Priors are independent normal distributions with the rig file's tolerances, cut at 2.5; sensors' zero errors have "
        "the tolerance of their data sheet, the clocks of drive and pressures 1 ms.",
        "Noise is white and of the size that the rig file says. The model may be off by a class of bins (the same place in "
        "the cycle) and by slow curves of temperature; what these can explain counts for nothing.",
        "The covariance is that of a model linear around the fit (Laplace). The rig file keeps each standard deviation but "
        "not the correlations between them.",
        "The free run is given speed command, payload and ambient; at each standstill its rod is put back to the measured "
        "position, and the error of the stroke before is what 'rod position' compares.",
    ]


def data_split(share: float) -> str:
    """What was fitted and what was held out."""
    if share:
        return (f"Fitted to the first {100 * (1 - share):.0f} % of each recording; the last {100 * share:.0f} % were held out "
                "and only predicted.")
    return "Fitted to the whole of each recording; nothing was held out, so the RMS is no test of prediction."


def calibration_end(fit: Calibration, experiments: Sequence[Experiment], share: float, given: str, seconds: float) -> doc.EndMatter:
    """What the numbers rest on; ``given``: rig file of the priors."""
    rows = [("Recordings", "; ".join(f"{e.recording.path} ({duration(e.duration)})" for e in experiments)),
            ("Computing time", f"{seconds:.1f} s, {fit.sweeps} times sensitivities, " + ("settled" if fit.settled else "not settled"))]
    return doc.EndMatter(data_split(share), given, assumptions(fit), rows)


def calibration_json(fit: Calibration, experiments: Sequence[Experiment], signals: Sequence[SignalFit], share: float, said: str,
                     given: str, seconds: float) -> dict:
    """Every number of the page."""
    return {
        "report": "calibration", "verdict": said,
        "recordings": [{"path": e.recording.path, "duration_s": e.duration, "fitted_until_s": e.used_until} for e in experiments],
        "signals": [{"name": s.name, "before_in_noise": s.before, "fitted_in_noise": s.after, "held_out_in_noise": s.held_out,
                     "held_out_samples": s.samples_held_out} for s in signals],
        "parameters": [{
            "name": p.name, "unit": p.unit, "prior": p.prior, "prior_std": p.prior_std, "value": p.value, "std": p.std,
            "std_share": p.share, "moved_in_prior_std": p.moved, "group": group_of(p, fit),
        } for p in fit.parameters],
        "only_together": [{"a": a, "b": b, "correlation": r} for a, b, r in fit.together()],
        "refused": [p.name for p in fit.refused],
        "correlation": fit.correlation.tolist(),
        "settled": fit.settled, "sweeps": fit.sweeps,
        "end_matter": calibration_end(fit, experiments, share, given, seconds).as_json() | {
            "rig_id": fit.rig.rig_id, "computing_time_s": seconds},
    }


def calibration_document(fit: Calibration, experiments: Sequence[Experiment], signals: Sequence[SignalFit], share: float, said: str,
                         mood: str, given: str, seconds: float) -> doc.Document:
    """The page.

    Args:
        share: held out. said, mood: verdict and its level. given: rig file of the priors. seconds: what the fit took.
    """
    page = doc.Document(kind="Calibration", title=fit.rig.rig_id, verdict=said, level=mood,
                        end=calibration_end(fit, experiments, share, given, seconds))
    groups = grouped(fit)
    worst = max(signals, key=lambda s: s.judged)
    page.add("At a glance", doc.figures([
        _fitted(fit),
        *(doc.Figure(group.capitalize(), str(len(groups[group])), _MEANING[group]) for group in GROUPS if groups[group]),
        doc.Figure("Furthest off", f"{number(worst.judged, 2)} × noise", words(worst.name) + (", held out" if share else "")),
    ]))
    page.add("Signals", _signals(signals), doc.note(_CHARTS), *(charts(_residuals(e, fit, share), (0.0, e.duration)) for e in experiments))
    page.add("What the recordings inform", _legend(groups), _bars(groups), _table(fit))
    page.add("Only together", _together(fit))
    return page


def _fitted(fit: Calibration) -> doc.Figure:
    """How many parameters were fitted, those that were asked for apart from what every fit needs."""
    if not fit.asked:
        return doc.Figure("Parameters fitted", str(len(fit.parameters)), "zero errors of sensors among them")
    beside = sum(p.name not in fit.asked for p in fit.parameters)
    return doc.Figure("Parameters asked for", str(len(fit.asked)), f"and {beside} that every fit needs: zero errors of sensors and clocks")


def _signals(signals: Sequence[SignalFit]) -> doc.Html:
    """Every signal; what was held out only where something was."""
    held = any(s.held_out is not None for s in signals)
    columns = [doc.Column("Signal", number=False), doc.Column("As given", "× noise"), doc.Column("Fitted", "× noise", number=held),
               *((doc.Column("Held out", "× noise", number=False), doc.Column("Samples", "held out")) if held else ())]

    def judged(value: float | None) -> doc.Html:
        return doc.mark("none", "–") if value is None else doc.mark(level(value), f"{number(value, 2)} ×")

    rows = [(words(s.name), number(s.before, 2),
             *((number(s.after, 2), judged(s.held_out), str(s.samples_held_out or "–")) if held else (judged(s.after),))) for s in signals]
    return doc.Html(doc.table(columns, rows) + doc.note(_RMS))


def _residuals(experiment: Experiment, fit: Calibration, share: float) -> list[Chart]:
    """Measured less predicted, each signal over time, in the unit that people read.

    What lies between the fitted part and what is held out counts nowhere and is not drawn.
    Samples are dots; where they are more than `_MOST_DOTS`, a line and a band tell mean, lowest and highest of `_SPANS` equal times.
    """
    predicted = experiment.predict(experiment.parameters(fit.rig), begin=None)
    several = []
    for name, signal in experiment.signals.items():
        unit = shown(signal.unit)
        off = (signal.measured - predicted[name]) * unit.factor
        parts = [("fitted part", "measured", signal.time <= experiment.used_until)]
        if share:
            parts.append(("held out", "predicted", signal.time > experiment.held_from))
        parts = [(label, role, np.where(here, off, np.nan)) for label, role, here in parts]
        time = signal.time
        if time.size > _MOST_DOTS:
            edges = np.linspace(time[0], time[-1], _SPANS + 1)
            for at in (experiment.used_until, experiment.held_from):  # no span holds a few samples of a part alone
                edges[np.argmin(np.abs(edges - at))] = at
            time = 0.5 * (edges[1:] + edges[:-1])
            told = ((label, role, mean_and_ends(signal.time, values, edges)) for label, role, values in parts)
            traces = [Trace(label, role, mean, ends=(low, high)) for label, role, (mean, low, high) in told]
        else:
            traces = [Trace(label, role, values, dots=True) for label, role, values in parts]
        band = np.full(time.size, FLOOR * signal.noise * unit.factor)
        traces.insert(0, Trace(f"{FLOOR:g} × sensor noise", "fused", np.zeros(time.size), spread=band))
        several.append(Chart(words(name).capitalize() + ", measured less predicted", unit.unit, time, traces,
                             digits=unit.digits, height=150))
    return several


def _legend(groups) -> doc.Html:
    return doc.legend((_ROLE[group], f"{group}: {_MEANING[group]}") for group in GROUPS if groups[group])


def _bars(groups) -> doc.Html:
    rows = [(p.name, ((_ROLE[group], 100.0 * p.share),)) for group in GROUPS for p in groups[group]]
    return doc.details("Standard deviation left of the prior's, every parameter", doc.bars(rows, "%", 0))


def _table(fit: Calibration) -> doc.Html:
    columns = (doc.Column("Parameter", number=False), doc.Column("Unit", number=False), doc.Column("Prior ± σ"),
               doc.Column("Fitted ± σ"), doc.Column("Moved", "σ prior"), doc.Column("σ left", "%"),
               doc.Column("Recordings", number=False))
    rows = [(p.name, "" if p.unit == "1" else p.unit, in_file(p.prior, p.prior_std), in_file(p.value, p.std), number(p.moved, 2),
             number(100.0 * p.share, 0), doc.mark(_MARK[group], group)) for group, members in grouped(fit).items() for p in members]
    return doc.table(columns, rows)


def _together(fit: Calibration) -> doc.Html:
    pairs = fit.together()
    if not pairs:
        return doc.paragraph("No pair of parameters has a posterior correlation beyond 0.95.")
    columns = (doc.Column("Parameter", number=False), doc.Column("and", number=False), doc.Column("Correlation"))
    return doc.Html(doc.note("Of these pairs the recordings tell a combination far better than either alone.")
                    + doc.table(columns, [(a, b, f"{r:+.3f}") for a, b, r in pairs]))
