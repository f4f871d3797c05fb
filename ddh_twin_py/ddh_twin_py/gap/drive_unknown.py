"""Which part of the direct driven unit free-form discrepancies point to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_twin_py.gap.hypotheses import WIDTH
from ddh_twin_py.gap.leftover import FreeForm
from ddh_twin_py.gap.refit import Refitted
from ddh_twin_py.gap.search import Found
from ddh_twin_py.gap.sensitivity import AMPLIFIED
from ddh_twin_py.gap.unknown import needed

_SENSED = {
    "motor_housing": "motor", "pump_1_case": "pump_1", "pump_2_case": "pump_2", "tank_oil": "tank", "tank_wall": "tank",
    "cylinder_barrel": "cylinder", "line_a": "line_a", "line_b": "line_b",
}
_FORCES = ("pressure_piston_side", "pressure_rod_side", "current", "electrical_power")
_OFF = 3.0  # mean square of a signal's deviations from which it is off
_ALONE = 0.1  # of the largest gain: what gains less stands aside


def place_of(found: Found, fitted: Refitted, forms: list[FreeForm]) -> tuple[str, str]:
    """Component and domain to which the free forms point, else that of the effect which resembles the gap most.

    A temperature that no other follows points to its own component, one pressure alone to its sensor: were it
    real, current or motion would follow. Piston-side pressure with current is force at the piston, whichever shows more; current
    or power without it is torque or loss of the motor.
    """
    power = found.linearised.power
    signals = {form.signal: form.gain for form in forms if form.gain > max(needed(form.signal, power), _ALONE * forms[0].gain)}
    leading = next((name for name in signals if name not in AMPLIFIED), None)
    if leading is not None:
        sensor = leading.removeprefix("temperature/")
        if sensor in _SENSED:
            return _SENSED[sensor], "thermal"
        if leading == "speed":
            return "drive", "electrical"
        if leading == "voltage":
            return "motor", "electrical"
        if leading.startswith("pressure_") and set(signals) <= {leading, *AMPLIFIED}:
            if not _off(found, found.fitted[()], ("current", "electrical_power", "rod_velocity", "rod_position")):
                return "sensor", "measurement"
            return _most_alike(found)
        forced = {"pressure_piston_side", leading} & {"pressure_piston_side", "pressure_rod_side"} & signals.keys()
        if forced and leading in _FORCES and signals.keys() & {"current", "electrical_power"}:
            return "cylinder", "mechanical"
        if leading in ("current", "electrical_power"):
            return "motor", "mechanical"
    if fitted.columns:
        sizes = [abs(x / c.x) for c, x in zip(fitted.columns, fitted.x, strict=True)]
        effect = fitted.columns[int(np.argmax(sizes))].effect
        if effect.component == "sensor" and len(_off(found, fitted, ("pressure_piston_side", "pressure_rod_side"))) > 1:
            return _most_alike(found)  # no single reading that lies bends both pressures
        return effect.component, effect.domain
    if leading is None and signals:
        return "motor", "thermal"
    return _most_alike(found)


def _off(found: Found, fitted: Refitted, names: Sequence[str]) -> list[str]:
    """Which of some signals are off in the first recording in which effects act, beside a hypothesis."""
    linearised = found.linearised
    number = linearised.model.altered.index(True)
    comparison = linearised.comparisons[number]
    residual = comparison.residual(fitted.predictions[number])
    return [b.signal for b in comparison.blocks if b.signal in names and float(np.mean(residual[b.rows] ** 2)) > _OFF]


def _most_alike(found: Found) -> tuple[str, str]:
    """Component and domain of the effect that resembles the gap most, real ones before sensors."""
    sums = found.linearised.evidence.sums
    explained = sums.score**2 / (np.diagonal(sums.information) + WIDTH**-2)
    real = [i for i, column in enumerate(found.linearised.columns) if column.effect.component != "sensor"]
    if not real:
        return "oil", "hydraulic"
    effect = found.linearised.columns[max(real, key=lambda i: explained[i])].effect
    return effect.component, effect.domain
