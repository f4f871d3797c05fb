"""What no listed effect explains: how probable, where, how large, on what it depends, its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ddh_twin_py.gap.diagnosis import Shape
from ddh_twin_py.gap.direct_drive import DirectDrive
from ddh_twin_py.gap.hypotheses import WIDTH
from ddh_twin_py.gap.lacking import PHASES
from ddh_twin_py.gap.leftover import FreeForm, free_forms
from ddh_twin_py.gap.refit import Refitted
from ddh_twin_py.gap.search import Found

NEEDED = 25.0
"""Log evidence that a free form must gain over the best listed hypothesis to be as likely as it."""
NEEDED_BY = {"temperature/motor_winding": 60.0}
"""The same for signals that a small flaw of the model moves far: the winding follows the square of every torque."""
REFUTED = 0.05
"""Worsening of held-out data, in multiples of the noise, from which a hypothesis is refuted."""
REFUTED_PROBABILITY = 0.7
_SOFTNESS = 2.0  # by which log odds are tempered: a free form's gain is no calibrated number
_POINTS = 12  # of a drawn shape


@dataclass(frozen=True)
class Unknown:
    """What is left beside the best listed hypothesis.

    Attributes:
        probability: that something outside the catalogue acts. forms: free forms, largest gain first.
        component, domain: where. size, unit: RMS of the largest free form. shapes: drawn.
    """

    probability: float
    forms: list[FreeForm]
    component: str
    domain: str
    size: float
    unit: str
    shapes: list[Shape] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def entry(self) -> dict:
        """By the contract's schema."""
        return {"component": self.component, "domain": self.domain, "size": self.size, "unit": self.unit,
                "depends_on": self.forms[0].depends_on if self.forms else []}


def unknown_beside(model: DirectDrive, found: Found, fitted: Refitted) -> Unknown:
    """Judge what a hypothesis leaves behind.

    Args:
        fitted: the best listed hypothesis, or none, at its optimum.
    """
    linearised = found.linearised
    variables = model.variables(linearised.comparisons, fitted.theta, fitted.acting)
    forms = sorted(free_forms(linearised, fitted, variables), key=lambda form: NEEDED_BY.get(form.signal, NEEDED) - form.gain)
    best = max((form.gain - NEEDED_BY.get(form.signal, NEEDED) for form in forms), default=-math.inf)
    probability = 1.0 / (1.0 + math.exp(-max(min(best / _SOFTNESS, 50.0), -50.0)))
    component, domain = _place(found, fitted, forms)
    number = model.altered.index(True)
    noise, unit = 1.0, "1"
    if forms:
        signal = model.signals[number][forms[0].signal]
        noise, unit = signal.noise, signal.unit
    shapes = _shapes(linearised, fitted, variables, number, forms[0], noise, unit) if forms and probability > 0.5 else []
    return Unknown(probability, forms, component, domain, forms[0].size * noise if forms else 0.0, unit, shapes)


def refuted(unknown: Unknown, shrinks: float) -> Unknown:
    """The same where the best listed hypothesis makes held-out data worse than no effect does: then it is not the cause.

    Args:
        shrinks: by how much it shrinks their gap, in multiples of the noise.
    """
    if shrinks > -REFUTED:
        return unknown
    note = ("the best listed hypothesis explains the field recording, but makes the held-out data worse by "
            f"{-shrinks:.2f} times the noise; it is not believed")
    return replace(unknown, probability=max(unknown.probability, REFUTED_PROBABILITY), notes=[note])


_SENSED = {
    "motor_housing": "motor", "pump_1_case": "pump_1", "pump_2_case": "pump_2", "tank_oil": "tank", "tank_wall": "tank",
    "cylinder_barrel": "cylinder", "line_a": "line_a", "line_b": "line_b",
}
_ALONE = 0.1  # of the largest gain: what gains less stands aside


def _place(found: Found, fitted: Refitted, forms: list[FreeForm]) -> tuple[str, str]:
    """Component and domain to which the free forms point, else that of the effect which resembles the gap most.

    A temperature that no other follows points to its own component, one pressure alone to its sensor: were it
    real, current or motion would follow. Piston-side pressure with current is force at the piston; current or power
    alone is torque or loss of the motor.
    """
    signals = {form.signal: form.gain for form in forms if form.gain > max(NEEDED_BY.get(form.signal, NEEDED), _ALONE * forms[0].gain)}
    leading = next((name for name in signals if name != "temperature/motor_winding"), None)
    if leading is not None:
        sensor = leading.removeprefix("temperature/")
        if sensor in _SENSED:
            return _SENSED[sensor], "thermal"
        if leading == "speed":
            return "drive", "electrical"
        if leading == "voltage":
            return "motor", "electrical"
        if leading.startswith("pressure_") and set(signals) <= {leading, "temperature/motor_winding"}:
            return "sensor", "measurement"
        if leading in ("pressure_piston_side", "pressure_rod_side") and signals.keys() & {"current", "electrical_power"}:
            return "cylinder", "mechanical"
        if leading in ("current", "electrical_power"):
            return "motor", "mechanical"
    if fitted.columns:
        sizes = [abs(x / c.x) for c, x in zip(fitted.columns, fitted.x, strict=True)]
        effect = fitted.columns[int(np.argmax(sizes))].effect
        return effect.component, effect.domain
    if leading is None and signals:
        return "motor", "thermal"
    sums = found.linearised.evidence.sums
    explained = sums.score**2 / (np.diagonal(sums.information) + WIDTH**-2)
    if not explained.size:
        return "oil", "hydraulic"
    effect = found.linearised.columns[int(np.argmax(explained))].effect
    return effect.component, effect.domain


def _shapes(linearised, fitted: Refitted, variables, number: int, form: FreeForm, noise: float, unit: str) -> list[Shape]:
    """Residual of the free form's signal over each variable, in bins of equal count."""
    comparison = linearised.comparisons[number]
    block = next(b for b in comparison.blocks if b.signal == form.signal)
    left = comparison.residual(fitted.predictions[number])[block.rows] * block.spread
    here = block.binning.phase != PHASES.index("transient")
    out = []
    axes = {"oil temperature, K": variables[number]["oil temperature"][block.rows], "speed, rad/s": variables[number]["speed"][block.rows],
            "time, s": block.binning.time}
    for name, values in axes.items():
        x, y = values[here], left[here]
        edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, _POINTS + 1))) if x.size else np.zeros(0)
        if edges.size < 3:
            continue
        which = np.clip(np.searchsorted(edges, x, "right") - 1, 0, edges.size - 2)
        count = np.bincount(which, minlength=edges.size - 1)
        good = count > 2
        mean = np.bincount(which, y, edges.size - 1)[good] / count[good]
        spread = np.sqrt(np.maximum(np.bincount(which, y**2, edges.size - 1)[good] / count[good] - mean**2, 0.0) / count[good])
        at = np.bincount(which, x, edges.size - 1)[good] / count[good]
        out.append(Shape(name, at, mean, spread, unit))
    return out
