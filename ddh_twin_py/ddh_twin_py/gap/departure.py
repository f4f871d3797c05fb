"""The size of an effect as it is reported: value, standard deviation, unit and nominal value."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.model import Diagnosable
from ddh_twin_py.gap.refit import Refitted


def departure_of(model: Diagnosable, fitted: Refitted, number: int) -> tuple[float, float, str, float | None]:
    """Value, standard deviation, unit and nominal value of an effect of a hypothesis.

    The standard deviation is that of the fit and what the effect's law may misjudge.
    """
    column = fitted.columns[number]
    effect = column.effect
    first = model.altered.index(True)
    record = model.record(first, fitted.theta)
    nominal = effect.reference(record)
    std = float(np.hypot(np.sqrt(max(fitted.covariance[number, number], 0.0)), effect.law_error * fitted.x[number]))
    if all(model.altered):  # held against the sheet: what the rig's own parameter took is part of the value
        sheet = model.record(first, np.zeros(model.size))
        plain = effect.reference(sheet)
        ratio = _ratio(effect, column.law, record, sheet) if plain == nominal else 1.0
        taken = _taken(effect, column.law, record, sheet) if plain == nominal == 0.0 else 0.0
        return (nominal + float(fitted.x[number])) * ratio + taken, std * ratio, effect.unit, plain
    return nominal + float(fitted.x[number]), std, effect.unit, nominal


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
