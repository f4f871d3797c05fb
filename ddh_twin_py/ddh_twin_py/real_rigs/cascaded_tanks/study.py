"""The cascaded tanks studied: effects found on the identification record, sized on the test record, which is read last."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.cascaded_tanks.candidate_tests import candidate_tests
from ddh_twin_py.real_rigs.cascaded_tanks.model import DESCRIPTION, NOTHING_FORGIVEN, Tanks, held_blocks
from ddh_twin_py.real_rigs.cascaded_tanks.recordings import IDENTIFICATION, SOURCE, TEST, TankRecord, read
from ddh_twin_py.real_rigs.controls import on_real, on_simulated
from ddh_twin_py.real_rigs.diagnose import Outcome, found_by, rounds
from ddh_twin_py.real_rigs.figures import interval, rms
from ddh_twin_py.real_rigs.fit import least_squares
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.study import Line, Picture, Row, Study

_PUBLISHED = "linear 0.75, Volterra 0.54, nonlinear state space 0.34, grey-box with overflow 0.18"
_SEEDS = (0, 1, 2)


def run(data: Path, progress: Callable[[float], None] | None = None) -> Study:
    """The whole study.

    Args:
        data: folder that holds ``cascaded_tanks/``. progress: told the share done.

    Raises:
        RecordingsError: see `recordings.read`.
    """
    told = progress or (lambda share: None)
    begun = time.perf_counter()
    first = read(data, IDENTIFICATION)
    held = held_blocks(first.level.size)
    baseline = RigModel(DESCRIPTION, [Tanks(first, ~held)], [Tanks(replace(first, name=f"{first.name}, every fourth block"), held)],
                        tests=candidate_tests(first))
    outcomes = rounds(baseline, lambda done: told(0.6 * done), discrepancy=NOTHING_FORGIVEN, start=least_squares)
    seconds = {"diagnoses": time.perf_counter() - begun}
    last = outcomes[-1]
    before, after = (_fitted(model, first) for model in (baseline, last.model))
    told(0.7)
    controls = [on_simulated(last.model, last.plain.theta, seed, NOTHING_FORGIVEN, least_squares) for seed in _SEEDS]
    told(0.9)
    test = read(data, TEST)
    controls.append(on_real(last, lambda outcome: _errors(outcome, test)))
    rows = [_row(first, before, after, "identification record, used to find and fit"), _row(test, before, after, "test record, held out")]
    seconds["figures and controls"] = time.perf_counter() - begun - seconds["diagnoses"]
    told(1.0)
    found = found_by(outcomes)
    sentence = f"{' and '.join(found) or 'No listed effect'} found on the identification record{_place(outcomes)}; RMS error of the test " \
               f"record, simulated from the pump's voltage alone, {rows[1].before:.3g} to {rows[1].after:.3g} V."
    splits = (("finding", f"{first.name}, three blocks of 256 s in four"), ("may refute", f"{first.name}, every fourth block"),
              ("parameters of the figures", f"{first.name}, all of it, by least squares"),
              ("figures", f"{test.name}, read after the last diagnosis"))
    names = [name for name in before.dtype.names if before[name][0] != after[name][0]]
    table = [("field", "before", "after"), *((name, f"{before[name][0]:.4g}", f"{after[name][0]:.4g}") for name in names)]
    return Study("cascaded_tanks", "Cascaded tanks", SOURCE, splits, sentence, found, outcomes, rows, controls,
                 (_picture(test, before, after),), {"Parameters": table}, assumptions=last.model.assumptions, seconds=seconds)


def _fitted(model: RigModel, record: TankRecord) -> np.ndarray:
    """Parameter record (1,) of a model, by least squares over a whole record."""
    whole = model.on([Tanks(record)])
    return whole.record(0, least_squares(whole))


def _level(record: TankRecord, parameters: np.ndarray) -> np.ndarray:
    return Tanks(record).predict(parameters)["level"]


def _row(record: TankRecord, before: np.ndarray, after: np.ndarray, split: str) -> Row:
    errors = [_level(record, parameters) - record.level for parameters in (before, after)]
    return Row("simulated level, RMS error", "V", split, record.level.size, *map(rms, errors), *map(interval, errors), _PUBLISHED)


def _errors(outcome: Outcome, record: TankRecord) -> tuple[float, float]:
    """RMS error of a record, V, without and with what an outcome believes."""
    return tuple(rms(_level(record, outcome.model.record(0, f.theta, f.acting)) - record.level) for f in (outcome.plain, outcome.leader))


def _place(outcomes: Sequence[Outcome]) -> str:
    """Where along the upper level the first effect that was built in adds most."""
    if "upper_tank.overflow" not in outcomes[0].believed:
        return ""
    rows = [row for row in outcomes[0].places() if row.component == "upper_tank" and row.regime.startswith("upper level")]
    return f" (most at {max(rows, key=lambda row: abs(row.value)).regime})"


def _picture(record: TankRecord, before: np.ndarray, after: np.ndarray) -> Picture:
    lines = [Line("measured", "measured", record.level)]
    lines += [Line(label, role, _level(record, p)) for label, role, p in (("before", "predicted", before), ("after", "fused", after))]
    return Picture("Level of the lower tank on the test record, simulated from the pump's voltage", "V", Tanks(record).time, lines,
                   ((0, 1), (0, 2)), "Below, measured less simulated.")
