"""What a free form of a signal must gain hangs on how far that signal can be believed."""

import pytest
from ddh_twin_py.gap.witnesses import UNSHOWN, USUAL, Witnesses

RIG = Witnesses({"rod_position": 30.0}, needed=9.0, needed_beside_none=-1.0)


@pytest.mark.parametrize(("signal", "effects", "needed"), [
    ("current", 1, 9.0), ("current", 2, 9.0), ("current", 0, -1.0), ("rod_position", 0, 30.0), ("rod_position", 1, 30.0),
])  # fmt: skip
def test_what_a_free_form_must_gain(signal, effects, needed):
    assert RIG.needed_of(signal, effects, shown=True) == needed
    assert RIG.needed_of(signal, effects, shown=False) == needed + UNSHOWN


@pytest.mark.parametrize(("signal", "effects"), [("current", 1), ("current", 0), ("rod_position", 1)])
def test_what_flaws_of_laws_gain_grows_with_the_recording(signal, effects):
    usual = RIG.needed_of(signal, effects, True)
    assert RIG.needed_of(signal, effects, True, 100.0) == usual == RIG.needed_of(signal, effects, True, USUAL)
    assert RIG.needed_of(signal, effects, True, 3.0 * USUAL) == pytest.approx(3.0 * usual + 20.0)
