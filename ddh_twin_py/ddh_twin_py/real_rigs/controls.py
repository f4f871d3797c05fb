"""Negative controls: where nothing more is to be found, nothing may be told."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ddh_twin_py.estimation.fitting.comparison import Discrepancy
from ddh_twin_py.real_rigs.diagnose import Outcome, diagnose
from ddh_twin_py.real_rigs.fit import by_steps
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.study import Control


def simulated(model: RigModel, theta: np.ndarray, seed: int = 0) -> RigModel:
    """The model on data that it simulated itself, with white noise of each signal's size.

    Args:
        model: with all effects that are believed built in. theta: its parameters, deviations, (k,).
    """
    rng = np.random.default_rng(seed)

    def read(run, record):
        predicted = run.predict(record)
        return run.measuring({name: predicted[name] + rng.normal(0.0, signal.noise, signal.time.size)
                              for name, signal in run.signals.items()})

    asked = model.record(model.first, theta)
    return model.on([read(run, asked) for run in model.field], [read(run, asked) for run in model.held],
                    [read(run, model.record(number, theta)) for number, run in enumerate(model.commissioning)])


def on_simulated(model: RigModel, theta: np.ndarray, seed: int = 0, discrepancy: Discrepancy | None = None,
                 start: Callable[[RigModel], np.ndarray] = by_steps) -> Control:
    """Data simulated from the corrected model must come back as no gap; see `simulated` and `diagnose`."""
    outcome = diagnose(simulated(model, theta, seed), discrepancy=discrepancy, start=start)
    return Control(f"data simulated from the corrected model, seed {seed}", "no_gap", said(outcome), outcome.verdict == "no_gap")


def on_real(outcome: Outcome, shrink: Callable[[Outcome], tuple[float, float]]) -> Control:
    """The corrected model on the real data: what is told with confidence must shrink the error of data that took no part.

    Args:
        outcome: of the corrected model. shrink: error of the test data without and with what the outcome believes.
    """
    expected = "no other effect with confidence, unless it reduces the held-out error"
    if not outcome.believed:
        return Control("the corrected model on the real data", expected, said(outcome), True)
    before, after = shrink(outcome)
    return Control("the corrected model on the real data", expected, f"{said(outcome)}; held-out error {before:.4g} to {after:.4g}",
                   after < before)


def said(outcome: Outcome) -> str:
    """The engine's verdict, and the leading listed set with its probability among listed ones."""
    leading, p = next(iter(outcome.listed.sets.items()))
    return f"{outcome.verdict}; of the listed {' + '.join(leading) or 'no effect'} ({p:.0%})"
