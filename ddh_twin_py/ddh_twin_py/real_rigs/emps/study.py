"""The EMPS studied: effects found on the identification record, sized on the record with pulses, which is read last."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.controls import on_real, on_simulated
from ddh_twin_py.real_rigs.diagnose import Outcome, found_by, rounds
from ddh_twin_py.real_rigs.emps import inverse
from ddh_twin_py.real_rigs.emps.candidate_tests import candidate_tests
from ddh_twin_py.real_rigs.emps.model import DESCRIPTION, HELD_SHARE, Axis
from ddh_twin_py.real_rigs.emps.recordings import IDENTIFICATION, PERIOD, PULSES, SOURCE, EmpsRecord, read
from ddh_twin_py.real_rigs.figures import interval, rms
from ddh_twin_py.real_rigs.fit import least_squares
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.signals import noise_of_repeats
from ddh_twin_py.real_rigs.study import Line, Picture, Row, Study

_PUBLISHED = "4.08 (symmetric, with offset) → 3.11"
_SEEDS = (0, 1, 2)


def run(data: Path, progress: Callable[[float], None] | None = None) -> Study:
    """The whole study.

    Args:
        data: folder that holds ``emps/``. progress: told the share done.

    Raises:
        RecordingsError: see `recordings.read`.
    """
    told = progress or (lambda share: None)
    seconds, begun = {}, time.perf_counter()
    first = read(data, IDENTIFICATION)
    noise = noise_of_repeats(first.force, PERIOD)
    baseline = RigModel(DESCRIPTION, [Axis(first, noise, HELD_SHARE)], tests=candidate_tests(first, noise))
    outcomes = rounds(baseline, lambda done: told(0.6 * done))
    seconds["diagnoses"] = time.perf_counter() - begun
    last = outcomes[-1]
    whole = [Axis(first, noise)]
    before, after = (_fitted(model.on(whole)) for model in (baseline, last.model))
    told(0.7)
    controls = [on_simulated(last.model, last.plain.theta, seed) for seed in _SEEDS]
    told(0.9)
    pulses = read(data, PULSES)
    controls.append(on_real(last, lambda outcome: _position_errors(outcome, pulses, noise)))
    rows = [*_inverse_rows(first, first, before, after, f"{IDENTIFICATION}, used to find and fit"),
            *_inverse_rows(first, pulses, before, after, f"{PULSES}, held out"),
            *_simulated_rows(pulses, before, after, noise, f"{PULSES}, held out")]
    seconds["figures and controls"] = time.perf_counter() - begun - seconds["diagnoses"]
    told(1.0)
    found = found_by(outcomes)
    sentence = f"{' and '.join(found) or 'No listed effect'} found on the identification record; on the record with pulses " \
               f"{_shrink(rows[2])}, {_shrink(rows[4])}."
    name = first.path.name
    splits = (("finding", f"{name}, the first {1.0 - HELD_SHARE:.0%}"), ("may refute", f"{name}, the rest"),
              ("parameters of the figures", f"{name}, all of it, by least squares"),
              ("figures", f"{pulses.path.name}, read after the last diagnosis"))
    return Study("emps", "Electro-mechanical positioning system (EMPS)", SOURCE, splits, sentence, found, outcomes, rows, controls,
                 (_picture(pulses, before, after, noise),), {"Parameters": _parameters(before, after)}, assumptions=last.model.assumptions,
                 notes=(f"Noise of the force: {noise:.2f} N, what repeats of the same motion scatter.",), seconds=seconds)


def _fitted(model: RigModel) -> np.ndarray:
    """Parameter record (1,) of a model by least squares."""
    return model.record(0, least_squares(model, starts=2))


def _inverse_rows(first: EmpsRecord, record: EmpsRecord, before: np.ndarray, after: np.ndarray, split: str) -> list[Row]:
    """Relative force error by the inverse model: with the parameters of the closed loop, and as the authors fit theirs."""
    learnt, motion = inverse.motion_of(first), inverse.motion_of(record)
    ours = [inverse.force_error(motion, parameters) for parameters in (before, after)]
    theirs = [inverse.least_squares_error(motion, inverse.least_squares(learnt, direction), direction) for direction in (False, True)]
    scale = 100.0 / (rms(ours[0]) / inverse.relative(ours[0], motion) * 100.0)
    return [Row(what, "%", split, errors[0].size, *(inverse.relative(e, motion) for e in errors),
                *((scale * low, scale * high) for low, high in map(interval, errors)), published)
            for what, errors, published in (("relative force error, inverse model", ours, _PUBLISHED),
                                            ("the same by the authors' least squares, offset → both directions", theirs, _PUBLISHED))]


def _simulated_rows(record: EmpsRecord, before: np.ndarray, after: np.ndarray, noise: float, split: str) -> list[Row]:
    """Errors of the closed loop, simulated from the reference alone."""
    axis = Axis(record, noise)
    runs = [axis.simulate(parameters) for parameters in (before, after)]
    positions, forces = ([(run[i] - measured)[50:] for run in runs] for i, measured in ((0, record.position), (1, record.force)))
    scale = 100.0 / rms(record.force[50:])
    rows = [("simulated position, RMS error", "µm", 1e6, positions), ("simulated force, relative error", "%", scale, forces)]
    return [Row(what, unit, split, errors[0].size, *(factor * rms(e) for e in errors),
                *((factor * low, factor * high) for low, high in map(interval, errors)))
            for what, unit, factor, errors in rows]


def _position_errors(outcome: Outcome, record: EmpsRecord, noise: float) -> tuple[float, float]:
    """RMS error of the simulated position, m, of a record, without and with what an outcome believes."""
    axis = Axis(record, noise)
    return tuple(rms(axis.simulate(outcome.model.record(0, f.theta, f.acting))[0] - record.position)
                 for f in (outcome.plain, outcome.leader))


def _parameters(before: np.ndarray, after: np.ndarray) -> list[tuple]:
    names = [name for name in before.dtype.names if before[name][0] != after[name][0]]
    return [("field", "before", "after"), *((name, f"{before[name][0]:.5g}", f"{after[name][0]:.5g}") for name in names)]


def _picture(record: EmpsRecord, before: np.ndarray, after: np.ndarray, noise: float) -> Picture:
    axis = Axis(record, noise)
    lines = [Line("measured", "measured", record.force)]
    lines += [Line(label, role, axis.simulate(p)[1]) for label, role, p in (("before", "predicted", before), ("after", "fused", after))]
    return Picture("Force on the record with pulses, simulated from the reference", "N", record.time, lines, ((0, 1), (0, 2)),
                   "Closed loop from the reference and the pulses alone; below, measured less simulated.")


def _shrink(row: Row) -> str:
    return f"{row.what} {row.before:.3g} to {row.after:.3g} {row.unit}"
