"""The catalogue of effects, one module per close family."""

from __future__ import annotations

from ddh_twin_py.gap.catalogue import electrical, friction, leakage, lines, load, measurement, oil, surroundings, thermal, valves
from ddh_twin_py.gap.effect import Effect

FAMILIES = (leakage, valves, oil, lines, friction, load, electrical, thermal, surroundings, measurement)
EFFECTS: dict[str, Effect] = {effect.id: effect for family in FAMILIES for effect in family.EFFECTS}
"""Effects by id."""
