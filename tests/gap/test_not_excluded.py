"""What "no gap" does not exclude."""

import math

from ddh_twin_py.gap.explain.detection import Detection
from ddh_twin_py.gap.not_excluded import NotExcluded
from ddh_twin_py.rig.sheet import CUT


def test_what_a_record_would_not_have_shown_is_no_part_of_no_gap():
    shown = Detection("load.mass", "kg", 1.0, 2.0, "current", {"faint": 0.1, "moderate": None, "clear": None})
    faint = Detection("pump_1.leakage", "1", -0.428, 7.0, "speed", {"faint": 0.1, "moderate": 1.0, "clear": 50.0}, 1.0)
    impossible = Detection("tank.cooling", "W/K", None, None, "", dict.fromkeys(("faint", "moderate", "clear")))
    far = Detection("motor.cooling", "1", 28.3, 2.8, "speed", dict.fromkeys(("faint", "moderate", "clear"), 9.0), 1.0, beyond=True)
    (note,) = NotExcluded({}, [], [shown, faint, impossible, far], {"pump_1.leakage": "leakage_ratio"}).notes(CUT)
    assert note.endswith(": pump_1.leakage (leakage ratio down to 0.572, as built 1.00), tank.cooling (at any size that it may have), "
                         "motor.cooling (up to 29.3, as built 1.00)")
    assert NotExcluded({}, [], [shown]).notes(CUT) == []


def test_what_is_known_of_since_when_nothing_tells_comes_first():
    left = NotExcluded({"b": "p 1 bar instead of the sheet's 2 bar"}, ["a", "b"], [])
    told = left.untold()
    assert list(told) == ["b", "a"]
    assert told["b"] == "the field recordings show p 1 bar instead of the sheet's 2 bar, the commissioning recording does not show it"
    assert told["a"].startswith("a value of the rig's own within its tolerance does the same")
    own, since = left.notes(CUT)
    assert own.startswith("the rig's own value within 2.5 times its tolerance explains what a would; ")
    assert since.startswith("b may have changed")
    assert left.notes(math.inf)[0].startswith("the rig's own value explains what a would; "), "nothing holds its parameters"
