"""The electro-hydraulic actuator studied: effects found on loads 1, 3 and 5, sized on loads 2 and 4, which are read last."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from ddh_twin_py.real_rigs.controls import on_real, on_simulated
from ddh_twin_py.real_rigs.diagnose import Outcome, found_by, rounds
from ddh_twin_py.real_rigs.eha import recordings
from ddh_twin_py.real_rigs.eha.balance import balance, ideal
from ddh_twin_py.real_rigs.eha.candidate_tests import candidate_tests
from ddh_twin_py.real_rigs.eha.model import DESCRIPTION, Stroke
from ddh_twin_py.real_rigs.eha.recordings import Actuation
from ddh_twin_py.real_rigs.figures import interval, rms
from ddh_twin_py.real_rigs.fit import least_squares
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.study import Line, Picture, Row, Study

FINDING, REFUTING, TEST = (1, 4), (2, 3), (2, 4)
"""Strokes of loads 1, 3 and 5 that find and that may refute; loads on which figures are taken."""
KNOWN_LOADS = (1, 3, 5)
_ROUNDS = 5  # many things differ from the sheet at once
_SEEDS = (0, 1, 2)
_UNITS = {"position": ("position in free run of each stroke", "mm", 1e3), "pressure_a": ("piston-side pressure in free run", "bar", 1e-5),
          "pressure_b": ("rod-side pressure in free run", "bar", 1e-5)}
_PUBLISHED = "0.91 ideal, 0.43 with side compliance"


def run(data: Path, progress: Callable[[float], None] | None = None) -> Study:
    """The whole study.

    Args:
        data: folder that holds ``eha/``. progress: told the share done.

    Raises:
        RecordingsError: see `recordings.read`.
    """
    told = progress or (lambda share: None)
    seconds, begun = {}, time.perf_counter()
    finding = recordings.read(data / "eha", KNOWN_LOADS, FINDING)
    refuting = recordings.read(data / "eha", KNOWN_LOADS, REFUTING)
    baseline = RigModel(DESCRIPTION, [Stroke(r) for r in finding], [Stroke(r) for r in refuting], tests=candidate_tests(finding[-1]))
    outcomes = rounds(baseline, lambda done: told(0.6 * done), most=_ROUNDS)
    seconds["diagnoses"] = time.perf_counter() - begun
    last = outcomes[-1]
    whole = [Stroke(r) for r in finding + refuting]
    before, after = (model.on(whole).record(0, least_squares(model.on(whole))) for model in (baseline, last.model))
    told(0.75)
    controls = [on_simulated(last.model, last.plain.theta, seed) for seed in _SEEDS]
    told(0.9)
    test = recordings.read(data / "eha", TEST)
    controls.append(on_real(last, lambda outcome: _errors(outcome, test)))
    rows = [*figures(whole, before, after, "loads 1, 3, 5, used to find and fit"),
            *figures([Stroke(r) for r in test], before, after, "loads 2, 4, held out")]
    seconds["figures and controls"] = time.perf_counter() - begun - seconds["diagnoses"]
    told(1.0)
    found = found_by(outcomes)
    own = rows[len(rows) // 2 :]
    sentence = f"{', '.join(found) or 'No listed effect'} found on loads 1, 3 and 5; on loads 2 and 4 {_shrink(own[0])}, {_shrink(own[3])}."
    splits = (("finding", "loads 1, 3, 5, strokes 1, 4"), ("may refute", "loads 1, 3, 5, strokes 2, 3"),
              ("parameters of the figures", "loads 1, 3, 5, least squares"), ("figures", "loads 2, 4, read after the last diagnosis"))
    return Study("eha", "Electro-hydraulic actuator", f"{recordings.WHERE}; no licence is stated", splits, sentence, found, outcomes, rows,
                 controls, _pictures([Stroke(r) for r in test], before, after), {"Parameters": _parameters(before, after)},
                 assumptions=last.model.assumptions,
                 notes=("Nothing is labelled: only what shrinks on loads that were not seen is claimed.",), seconds=seconds)


def figures(runs: Sequence[Stroke], before: np.ndarray, after: np.ndarray, split: str) -> list[Row]:
    """Root mean squares over some records with two parameter records (1,)."""
    rows = []
    predicted = [[run.predict(p) for run in runs] for p in (before, after)]
    for name, (what, unit, factor) in _UNITS.items():
        errors = [np.concatenate([_counted(run, name, said) for run, said in zip(runs, own, strict=True)]) for own in predicted]
        rows.append(_row(what, unit, split, [factor * e for e in errors]))
    for moving, what in ((True, "flow balance over 0.1 s, pump moving"), (False, "flow balance over 0.1 s, all windows")):
        errors = [np.concatenate([_left(run.record, p, moving) for run in runs]) for p in (before, after)]
        perfect = np.concatenate([_left(run.record, ideal(), moving) for run in runs])
        rows.append(_row(what, "cm3", split, [1e6 * e for e in errors], f"ideal here {1e6 * rms(perfect):.2f}; {_PUBLISHED}"))
    return rows


def _row(what: str, unit: str, split: str, errors: Sequence[np.ndarray], published: str = "") -> Row:
    return Row(what, unit, split, errors[0].size, *map(rms, errors), *map(interval, errors), published)


def _counted(run: Stroke, name: str, said: dict[str, np.ndarray]) -> np.ndarray:
    error = run.signals[name].measured - said[name]
    return error[np.isfinite(error)]


def _left(record: Actuation, p: np.ndarray, moving: bool) -> np.ndarray:
    left, moves = balance(record, p[0])
    return left[np.isfinite(left) & (moves | (not moving))]


def _errors(outcome: Outcome, test: Sequence[Actuation]) -> tuple[float, float]:
    """RMS over all signals of the test records in multiples of their noise, without and with what an outcome believes."""
    runs = [Stroke(r) for r in test]
    out = []
    for fitted in (outcome.plain, outcome.leader):
        record = outcome.model.record(outcome.model.first, fitted.theta, fitted.acting)
        predicted = [run.predict(record) for run in runs]
        out.append(rms(np.concatenate([_counted(run, name, said) / run.signals[name].noise
                                       for run, said in zip(runs, predicted, strict=True) for name in run.signals])))
    return out[0], out[1]


def _parameters(before: np.ndarray, after: np.ndarray) -> list[tuple]:
    names = [name for name in before.dtype.names if before[name][0] != after[name][0]]
    return [("field", "before", "after"), *((name, f"{before[name][0]:.4g}", f"{after[name][0]:.4g}") for name in names)]


def _pictures(runs: Sequence[Stroke], before: np.ndarray, after: np.ndarray) -> list[Picture]:
    """The longest strokes of the test loads."""
    out = []
    for run in runs:
        if run.record.stroke == recordings.STROKES[-1]:
            said = [run.predict(p) for p in (before, after)]
            for name, (what, unit, factor) in _UNITS.items():
                lines = [Line(label, role, factor * own) for label, role, own in (
                    ("measured", "measured", getattr(run.record, name)), ("before", "predicted", said[0][name]),
                    ("after", "fused", said[1][name]))]
                out.append(Picture(f"{run.name}: {what}", unit, run.record.time, lines, ((0, 1), (0, 2))))
    return out


def _shrink(row: Row) -> str:
    return f"{row.what} {row.before:.3g} to {row.after:.3g} {row.unit}"
