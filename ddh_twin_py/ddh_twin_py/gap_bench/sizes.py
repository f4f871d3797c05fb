"""How large an effect is made: so that it is seen as clearly as its level says."""

from __future__ import annotations

import math
from collections.abc import Callable

from ddh_twin_py.gap_bench.visibility import Feigned, Scene, rises
from ddh_twin_py.plant.fault import Fault

RISE = {"clear": 11.0, "moderate": 5.0, "faint": 2.2}
"""With a commissioning recording: RMS of with less without over the sensor's noise, on the worst signal but the winding."""
DEVIATIONS = {"clear": 6.0, "moderate": 4.5, "faint": 3.3}
"""Without one: standard deviations of what the tolerances can feign."""
_NEAR = 0.06
_MOST_RUNS = 12


def worst(view: Scene, fault: Fault, departure: float) -> tuple[str, float]:
    """Signal that an effect moves most, and by how many times its noise."""
    found = rises(view, view.readings_with([(fault, departure)]))
    return max(found.items(), key=lambda item: item[1])


def sized(fault: Fault, sign: float, level: str, view: Scene, feigned: Feigned | None) -> float | None:
    """Departure at which an effect is as clear as its level asks; None where no possible one is.

    Args:
        feigned: given where there is no commissioning recording.
    """
    if feigned is None:
        target = RISE[level]

        def measure(size: float) -> float:
            return worst(view, fault, sign * size)[1]

        return _signed(sign, _solve(measure, target, fault.step, fault.limit(sign)))
    target = DEVIATIONS[level]

    def measure(size: float) -> float:
        return feigned.distance(view, view.readings_with([(fault, sign * size)]))

    size = _solve(measure, target, fault.step, fault.limit(sign))
    if size is None:
        return None
    size = max(size, target * _own_deviation(fault, view))
    if size > fault.limit(sign) or worst(view, fault, sign * size)[1] < RISE["faint"]:
        return None
    return sign * size


def _own_deviation(fault: Fault, view: Scene) -> float:
    """Deviation of the reported quantity that the sheet itself allows, 0 where it gives none."""
    variance = 0.0
    for path, power in fault.paths:
        quantity = view.machine.rig.quantities[path]
        scale = 1.0 if fault.ratio or fault.id == "drive.torque_estimate" else abs(quantity.value)
        if fault.id == "load.mass":
            scale = view.duty.exercise.payload
        variance += (power * quantity.tolerance * scale) ** 2
    return math.sqrt(variance)


def _signed(sign: float, size: float | None) -> float | None:
    return None if size is None else sign * size


def _solve(measure: Callable[[float], float], target: float, first: float, limit: float) -> float | None:
    """Size at which a rising measure meets its target within `_NEAR`, by bisection in the logarithm; None beyond the limit."""
    low, high = None, None
    size = min(first, limit)
    for _ in range(_MOST_RUNS):
        value = measure(size)
        if not math.isfinite(value):
            return None
        if abs(value / target - 1.0) < _NEAR:
            return size
        if value < target:
            low = size
            if size >= limit:
                return None
        else:
            high = size
        if low is not None and high is not None:
            size = math.sqrt(low * high)
        else:
            wanted = target / max(value, 1e-3) * (0.97 if value > target else 1.03)
            size = min(limit, size * min(8.0, max(0.05, wanted)))
    return None if high is None else high
