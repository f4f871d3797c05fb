"""Where the unit's signals say that something unknown is."""

from types import SimpleNamespace

import pytest
from ddh_twin_py.gap.drive_unknown import place_of
from ddh_twin_py.gap.hypotheses import POWER
from ddh_twin_py.gap.leftover import FreeForm


@pytest.mark.parametrize("gains, place", [
    ({"electrical_power": 147.0, "current": 123.0, "pressure_piston_side": 61.0}, ("cylinder", "mechanical")),  # a force: torque follows
    ({"pressure_piston_side": 90.0, "current": 30.0}, ("cylinder", "mechanical")),
    ({"electrical_power": 147.0, "current": 123.0}, ("motor", "mechanical")),
    ({"electrical_power": 147.0, "current": 123.0, "pressure_piston_side": 20.0}, ("motor", "mechanical")),  # no more than a flaw of laws
    ({"electrical_power": 147.0, "current": 123.0, "pressure_rod_side": 61.0}, ("motor", "mechanical")),
    ({"temperature/line_a": 200.0, "current": 30.0}, ("line_a", "thermal")),
    ({"voltage": 60.0, "current": 30.0}, ("motor", "electrical")),
    ({"temperature/motor_winding": 200.0, "speed": 30.0}, ("drive", "electrical")),
])  # fmt: skip
def test_signals_point_to_the_part_whose_balance_they_break(gains, place):
    found = SimpleNamespace(linearised=SimpleNamespace(power=POWER))
    forms = [FreeForm(name, gain, 2.0, ["phase"], "lifting") for name, gain in sorted(gains.items(), key=lambda item: -item[1])]
    assert place_of(found, SimpleNamespace(columns=()), forms) == place
