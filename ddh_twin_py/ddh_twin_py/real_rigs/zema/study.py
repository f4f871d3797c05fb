"""The ZeMA rig studied: network fitted to the known cycles, every cycle's condition, oil in free run, the engine on single runs."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from ddh_twin_py.real_rigs.controls import on_real, on_simulated
from ddh_twin_py.real_rigs.diagnose import found_by
from ddh_twin_py.real_rigs.figures import interval, rms
from ddh_twin_py.real_rigs.fit import fit
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.study import Control, Line, Picture, Row, Study
from ddh_twin_py.real_rigs.zema import conditions as condition
from ddh_twin_py.real_rigs.zema import levels, recordings
from ddh_twin_py.real_rigs.zema.catalogue import DESCRIPTION
from ddh_twin_py.real_rigs.zema.conditions import COMPONENTS, Conditions
from ddh_twin_py.real_rigs.zema.examples import Example, ask
from ddh_twin_py.real_rigs.zema.features import Features, features
from ddh_twin_py.real_rigs.zema.free_run import simulated, with_conditions
from ddh_twin_py.real_rigs.zema.model import NOISE, Cycles, measured
from ddh_twin_py.real_rigs.zema.recordings import SECONDS

_SIMULATED_NOISE = {**NOISE, "temperature": 0.02}
_FEW = 0.05  # of the cycles
_FIGURES = {"flow": ("flow through the load", "L/min"), "stored": ("oil stored at a step between the higher loads", "L"),
            "opening": ("opening time of the valve", "s"), "closing": ("closing time of the valve", "s")}


def run(data: Path, progress: Callable[[float], None] | None = None) -> Study:
    """The whole study.

    Args:
        data: folder that holds ``zema/``. progress: told the share done.

    Raises:
        RecordingsError: see `recordings.read`.
    """
    told = progress or (lambda share: None)
    seconds, begun = {}, time.perf_counter()

    def lap(name: str) -> None:
        seconds[name] = time.perf_counter() - begun - sum(seconds.values())

    record = recordings.read(data / "zema")
    known = np.isin(np.arange(record.cycles), record.known)
    f = features(record.signals)
    baseline = RigModel(DESCRIPTION, [Cycles(record, block) for block in record.blocks()])
    with ThreadPoolExecutor(2) as pool:
        p = baseline.record(0, fit(baseline, pool).theta)[0]
    lap("reading and fit")
    told(0.05)
    found = condition.conditions(f, p, known, lambda done: told(0.05 + 0.35 * done))
    lap("conditions of all cycles")
    examples = ask(record, found, known, lambda done: told(0.4 + 0.2 * done))
    lap("engine on single runs")
    controls = _controls(f, p, known, found, examples, lambda done: told(0.6 + 0.4 * done))
    lap("controls")
    rows = _rows(f, p, known, found)
    named = [c for c in COMPONENTS if found.estimate[c] is not None]
    split = f"{int((~known).sum())} cycles not known beforehand"
    gap = [rms(np.array(values)) for values in ([r.before for r in rows[:4]], [r.after for r in rows[:4]])]
    sentence = f"{', '.join(named) or 'nothing'} can be told cycle by cycle; oil temperatures in free run part from the record by " \
               f"{gap[0]:.2g} K with all in best condition and by {gap[1]:.2g} K as found."
    tables = {"Levels": _levels(found), "Cycles by verdict": _verdicts(found), "The engine on single runs": _engine(examples),
              "Against the virtual sensors (a check, no evidence)": _virtual(data / "zema", found)}
    before, after = with_conditions(f, p), with_conditions(f, p, found)
    return Study(
        "zema", "Hydraulic test rig of ZeMA", recordings.WHERE,
        (("network and best condition", f"{record.known.size} known cycles"), ("conditions", "all cycles, blind"), ("figures", split)),
        sentence, list(dict.fromkeys(name for e in examples for name in found_by(e.outcomes))), [o for e in examples for o in e.outcomes],
        rows, controls, _pictures(f, found, before, after), tables, {"zema_cycles.csv": condition.as_csv(found)}, DESCRIPTION.assumptions,
        ("A cycle's condition is estimated from that same cycle and its neighbours: the figures after say how much of the record a few "
         "levels explain, and are no forecast.",), seconds)


def _rows(f: Features, p: np.void, known: np.ndarray, found: Conditions) -> list[Row]:
    """Free run before and after, on cycles that are not known."""
    before, after, read = with_conditions(f, p), with_conditions(f, p, found), measured(f)
    out = []
    for name in [*(f"temperature/TS{i}" for i in (1, 2, 3, 4)), *_FIGURES]:
        what, unit = _FIGURES.get(name, (f"{name.partition('/')[2]} in free run", "K"))
        own = np.s_[:, condition.HIGH] if name == "stored" else np.s_[:]
        errors = [(read[name][own] - said[name][own])[~known].ravel() for said in (before, after)]
        errors = [e[np.isfinite(e)] for e in errors]
        out.append(Row(what, unit, "cycles not known beforehand", errors[0].size, rms(errors[0]), rms(errors[1]), *map(interval, errors)))
    return out


def _controls(f: Features, p: np.void, known: np.ndarray, found: Conditions, examples: list[Example], told) -> list[Control]:
    """Nothing may be told of a simulated rig in best condition, of the record with what was found taken out, or by the engine again."""
    out = []
    again = condition.conditions(simulated(f, p, _SIMULATED_NOISE, 0), p, known, lambda done: told(0.4 * done))
    told_of = sorted(set(again.verdict) - {"none"})
    out.append(Control("all cycles simulated in best condition", "verdict none in every cycle", ", ".join(told_of) or "none", not told_of))
    est = condition.estimates(f, p, known)
    values = condition.values_of(est, found.direction)
    for i, component in enumerate(COMPONENTS):
        own = found.found[component]
        series = condition.series_of(component, values[component] - own.probability @ own.shift, est, known, p)
        out.append(_taken_out(component, series))
        told(0.4 + 0.1 * (i + 1))
    for example in examples:
        last = example.outcomes[-1]
        control = on_real(last, lambda outcome: (outcome.diagnosis.gap("before"), outcome.diagnosis.gap("after")))
        out.append(replace(control, what=f"{control.what}, {last.model.field[0].name}"))
        control = on_simulated(last.model, last.plain.theta)
        out.append(replace(control, what=f"{control.what}, {last.model.field[0].name}"))
    told(1.0)
    return out


def _taken_out(component: str, series: levels.Series) -> Control:
    """What is left of a component once its levels are taken out: a further level must be confirmed by cycles that take no part."""
    rest = levels.find(series, (2,), condition.SIGNS[component])
    share = float(np.mean(rest.worse > 0.5))
    confirmed = share >= _FEW and condition.confirmed_by(series, rest)
    said = f"a further level in {share:.1%} of cycles"
    if share >= _FEW:
        said += f", {rest.shift[-1]:+.2g} away, {'confirmed' if confirmed else 'not confirmed'}"
    return Control(f"{component}: the record with the levels taken out", "no further level, unless left-out cycles confirm it", said,
                   share < _FEW or confirmed)


def _levels(found: Conditions) -> list[tuple]:
    rows: list[tuple] = [("component", "levels", "shift from the best", "noise", "cycles at each level", "left-out cycles confirm them")]
    units = {"cooler": "", "valve": " s", "pump_leakage": " L/min", "accumulator": " (log of p0 V0)"}
    for component, one in found.found.items():
        counts = np.bincount(one.probability.argmax(axis=1), minlength=one.shift.size)
        rows.append((component, one.shift.size, ", ".join(f"{s:.3g}" for s in one.shift) + units[component], f"{one.noise:.2g}",
                     ", ".join(str(c) for c in counts), "yes" if found.confirmed[component] else "no"))
    return rows


def _verdicts(found: Conditions) -> list[tuple]:
    return [("verdict", "cycles"), *((name, found.verdict.count(name)) for name in (*COMPONENTS, "none"))]


def _engine(examples: list[Example]) -> list[tuple]:
    rows: list[tuple] = [("cycles", "levels say", "the engine builds in", "rounds")]
    for e in examples:
        said = ", ".join(f"{component} at level {level}" for component, level in e.levels.items()) or "all at their best"
        rows.append((f"{e.cycles.start} to {e.cycles.stop - 1}", said, ", ".join(found_by(e.outcomes)) or "nothing", len(e.outcomes)))
    return rows


def _virtual(folder: Path, found: Conditions) -> list[tuple]:
    """Rank correlation of the estimates with the means of the virtual sensors."""
    rows: list[tuple] = [("estimate", "virtual sensor", "rank correlation")]
    with np.load(folder / "sensors_1hz.npz") as archive:
        for component, name in (("cooler", "CE"), ("cooler", "CP"), ("pump_leakage", "SE")):
            values = archive[name] if name in archive.files else np.zeros(0)
            if found.estimate[component] is not None and values.shape == (len(found.verdict), SECONDS) and values.dtype.kind == "f":
                rank = spearmanr(found.estimate[component], values.mean(axis=1)).statistic
                rows.append((component, name, f"{rank:.3f}"))
    return rows


def _pictures(f: Features, found: Conditions, before: dict, after: dict) -> list[Picture]:
    time = SECONDS * (np.arange(f.power.size) + 0.5)
    out = []
    for i in (3, 4):
        name = f"temperature/TS{i}"
        lines = [Line("measured", "measured", f.temperature[:, i - 1]), Line("all in best condition", "predicted", before[name]),
                 Line("as found", "fused", after[name])]
        out.append(Picture(f"Oil temperature TS{i} in free run", "°C", time, lines, ((0, 1), (0, 2)),
                           "From the first reading on, with motor power and flows as inputs; below, measured less said."))
    for component in COMPONENTS:
        if found.estimate[component] is not None:
            lines = [Line(component, "fused", found.estimate[component]), Line("probability of not being at its best", "predicted",
                                                                              found.worse[component])]
            out.append(Picture(f"{component}: estimated condition", "L/min" if component == "pump_leakage" else "1", time, lines))
    return out
