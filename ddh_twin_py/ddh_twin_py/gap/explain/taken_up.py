"""Whether the rig's parameters could do what an effect does: a parameter within its tolerance must not pass for an effect.

An effect on a quantity that commissioning did not show acts as the parameter itself would; the fit without it may miss this,
because the parameter's sensitivity is taken at one place.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.model import Model

_STEP = 0.01  # deviations
_REACHED = 0.05  # of what the effect changes, that parameters may leave over
_MOVED = 0.3  # deviations of a parameter that count
_SHOWN = 1.0  # information, in inverse squares of its tolerance, from which a recording shows a parameter
_SURELY = 3.0  # posterior deviations from the sheet, from which a parameter surely is another


def taken_up(model: Model, theta: np.ndarray, acting: Acting) -> np.ndarray | None:
    """Parameters (k,) that change the record of the first altered recording as effects do, None where none can.

    Args:
        theta: parameters beside the effects, in deviations, (k,).
    """
    return _instead(model, theta, acting, _nearby(model, theta))


def _nearby(model: Model, theta: np.ndarray) -> np.ndarray:
    """Record of the first altered recording with each parameter a step further, (fields, k)."""
    number = model.altered.index(True)
    return np.column_stack([_numbers(model.record(number, theta + step)) for step in _STEP * np.eye(theta.size)])


def _instead(model: Model, theta: np.ndarray, acting: Acting, near: np.ndarray) -> np.ndarray | None:
    """As `taken_up`; near as of `_nearby`, which several effects at the same parameters have in common."""
    number = model.altered.index(True)
    plain, acted = _numbers(model.record(number, theta)), _numbers(model.record(number, theta, acting))
    moved = np.flatnonzero(acted != plain)
    if not moved.size:
        return None
    scale = np.abs(plain[moved]) + np.abs(acted[moved])
    slopes = (near[moved] - plain[moved, None]) / (_STEP * scale[:, None])
    wanted = (acted[moved] - plain[moved]) / scale
    change = np.linalg.lstsq(slopes, wanted, rcond=None)[0]
    if np.linalg.norm(slopes @ change - wanted) > _REACHED * np.linalg.norm(wanted):
        return None
    return model.within(theta + change)


def not_shown(linearised: Linearised, fitted: Refitted) -> bool:
    """Whether parameters that the recordings without effects do not show would do what a hypothesis' effects do.

    Then no recording says since when it is so.
    """
    if all(linearised.model.altered):
        return False
    moved = _moved(taken_up(linearised.model, fitted.theta, fitted.acting), fitted.theta)
    return bool(moved.size and (_told_before(linearised)[moved] < _SHOWN).all())


def shown_since(linearised: Linearised, theta: np.ndarray, spread: np.ndarray) -> dict[str, int]:
    """Effects in whose place one parameter stands that altered recordings alone show, and surely show otherwise than the sheet says.

    Args:
        theta, spread: parameters and their posterior standard deviations, in deviations, (k,).

    Returns:
        effect to the index of that parameter; empty where there are no recordings without effects.
    """
    if all(linearised.model.altered):
        return {}
    otherwise = (_told_before(linearised) < _SHOWN) & (np.abs(theta) > _SURELY * spread)
    found: dict[str, int] = {}
    near = _nearby(linearised.model, theta)
    for column in linearised.columns:
        if column.effect.id not in found:
            moved = _moved(_instead(linearised.model, theta, [(column.effect, column.law, column.x)], near), theta)
            if moved.size == 1 and otherwise[moved[0]]:
                found[column.effect.id] = int(moved[0])
    return found


def _moved(instead: np.ndarray | None, theta: np.ndarray) -> np.ndarray:
    """Indices of parameters that have to move to do what effects do; none where they cannot."""
    return np.flatnonzero([] if instead is None else np.abs(instead - theta) > _MOVED)


def _told_before(linearised: Linearised) -> np.ndarray:
    """Information that recordings without effects hold of each parameter, as the evidence weighs it, (k,)."""
    built = [j for j, altered in zip(linearised.sensitivities, linearised.model.altered, strict=True) if not altered]
    return linearised.power * sum(np.sum(j**2, axis=0) for j in built)


def _numbers(record: np.ndarray) -> np.ndarray:
    return np.array([float(record[name][0]) for name in record.dtype.names])
