"""Which terms of the direct driven unit's model may be learned at a place."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.gap.effect import Apply, Effect, added, fixed
from ddh_twin_py.gap.learned import PREFIX

_HEATED = ("motor", "pump_1", "pump_2", "line_a", "line_b", "cylinder", "tank")
_RESISTANCES = {  # further friction beside the sheet's: name, unit, step
    "motor": (("friction_coulomb", "N*m", 0.05), ("friction_viscous", "N*m*s", 5.0e-4)),
    "pump_1": (("friction_constant", "N*m", 0.1), ("friction_viscous", "N*m*s", 1.0e-3)),
    "pump_2": (("friction_constant", "N*m", 0.1), ("friction_viscous", "N*m*s", 1.0e-3)),
    "cylinder": (("friction_coulomb", "N", 100.0), ("friction_viscous", "N*s/m", 500.0)),
}


def terms_at(component: str, domain: str) -> list[Effect]:
    """Heat that is constant and heat that grows with speed, where heat is in question; friction, constant and growing, where force is."""
    if domain == "thermal" and component in _HEATED:
        return [_term(component, "thermal", f"learned_{component}_heat", "heat", "W", 10.0),
                _term(component, "thermal", f"learned_{component}_heat_by_speed", "heat_by_speed", "W*s", 0.3)]
    if domain == "mechanical":
        return [_term(component, domain, f"{component}_{name}", name, *row) for name, *row in _RESISTANCES.get(component, ())]
    return []


def _not_below_zero(field: str) -> Apply:
    """A law that adds the departure to a field of the record that cannot be negative."""

    def apply(record: np.ndarray, x: float) -> None:
        record[field] = np.maximum(record[field] + x, 0.0)

    return apply


def _term(component: str, domain: str, field: str, name: str, unit: str, step: float) -> Effect:
    law = added(field) if field.startswith("learned_") else _not_below_zero(field)
    return Effect(
        id=f"{PREFIX}{component}_{name}", component=component, domain=domain, parameter=name, unit=unit, reference=fixed(0.0),
        laws=(law,), step=step, lowest=-400.0 * step, highest=400.0 * step, about="learned from a recording; its cause is unknown",
    )
