"""The catalogue of effects, one module per close family."""

from __future__ import annotations

from dataclasses import replace

from ddh_twin_py.gap.catalogue import electrical, friction, leakage, lines, load, measurement, oil, surroundings, thermal, valves
from ddh_twin_py.gap.effect import Effect

FAMILIES = (leakage, valves, oil, lines, friction, load, electrical, thermal, surroundings, measurement)
LAW_ERROR = 0.1
"""Share of its size by which the law of a physical effect may misjudge it: with it 19 of 21 sizes that were found in an independent
plant, whose laws are others, lie within 95 %; without it 13. A sensor's zero, gain or clock has no other law; its lag and contact are read
off temperatures, whose course depends on laws too."""
_BY_THEMSELVES = {e.id for e in measurement.EFFECTS} - {"sensor.temperature_lag", "sensor.surface_contact"}
EFFECTS: dict[str, Effect] = {
    effect.id: replace(effect, law_error=0.0 if effect.id in _BY_THEMSELVES else LAW_ERROR)
    for family in FAMILIES for effect in family.EFFECTS
}
"""Effects by id."""
