"""The size of an effect as it is reported: value, standard deviation, unit and nominal value."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.model import DescribedModel

_STEP = 0.05  # of a tolerance, and of a departure
_PARAMETER_ERROR = 0.35
"""Share of its tolerance by which laws that are not quite the rig's misjudge a fitted parameter: RMS of five in an independent plant."""


def departure_of(model: DescribedModel, fitted: Refitted, number: int) -> tuple[float, float, str, float | None]:
    """Value, standard deviation, unit and nominal value of an effect of a hypothesis.

    The standard deviation is that of the fit, with the rig's own parameters where the value is counted from them, and what laws may
    misjudge, or what a body of unknown warmth does.
    """
    effect, law = fitted.columns[number].effect, fitted.columns[number].law
    theta, x = fitted.theta, float(fitted.x[number])
    value, nominal = _reported(model, effect, law, theta, x)
    slope = np.zeros(fitted.joint.shape[0])
    for i in range(theta.size):
        near = theta.copy()
        near[i] += _STEP
        slope[i] = (_reported(model, effect, law, near, x)[0] - value) / _STEP
    moved = (1.0 + _STEP) * x if x else effect.step
    by_effect = slope[theta.size + number] = (_reported(model, effect, law, theta, moved)[0] - value) / (moved - x)
    laws = np.append(_PARAMETER_ERROR * slope[: theta.size], np.hypot(effect.law_error, effect.unsteady) * by_effect * x)
    return value, float(np.sqrt(max(float(slope @ fitted.joint @ slope), 0.0) + laws @ laws)), effect.unit, nominal


def _reported(model: DescribedModel, effect: Effect, law: int, theta: np.ndarray, x: float) -> tuple[float, float | None]:
    """Value of the effect's parameter, and its nominal value, where it departs by x beside parameters theta, (k,)."""
    first = model.altered.index(True)
    record = model.record(first, theta)
    nominal = effect.reference(record)
    if not all(model.altered):
        return nominal + x, nominal
    sheet = model.record(first, np.zeros(model.size))  # held against the sheet: what the rig's own parameter took is part of the value
    plain = effect.reference(sheet)
    if plain != nominal:
        return nominal + x, plain
    taken = _taken(effect, law, record, sheet) if plain == 0.0 else 0.0
    return (nominal + x) * _ratio(effect, law, record, sheet) + taken, plain


def _taken(effect: Effect, law: int, record: np.ndarray, sheet: np.ndarray) -> float:
    """Departure that the rig's own fitted parameters stand for where the effect adds to one quantity that the sheet has too, else 0."""
    moved = record.copy()
    effect.laws[law](moved, effect.step)
    fields = [field for field in record.dtype.names if moved[field][0] != record[field][0]]
    if len(fields) != 1:
        return 0.0
    field = fields[0]
    return float((record[field][0] - sheet[field][0]) * effect.step / (moved[field][0] - record[field][0]))


def _ratio(effect: Effect, law: int, record: np.ndarray, sheet: np.ndarray) -> float:
    """Fitted over sheet value of what the effect scales, 1 where it adds."""
    moved = record.copy()
    effect.laws[law](moved, 0.01)
    for field in record.dtype.names:
        if moved[field][0] != record[field][0] and sheet[field][0] != 0.0 and effect.reference(record) == 1.0:
            ratio = float(record[field][0] / sheet[field][0])
            return ratio if moved[field][0] > record[field][0] else 1.0 / ratio
    return 1.0
