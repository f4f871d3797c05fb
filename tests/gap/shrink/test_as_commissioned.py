"""Whether later recordings are what the rig would show as it was commissioned."""

import numpy as np
import pytest
from ddh_twin_py.gap.shrink.as_commissioned import SURPRISED, UNSURPRISING, Surprise, something_acts, surprises
from ddh_twin_py.gap.shrink.size import counted
from support.first_order import EFFECTS, FirstOrder

BUILT = np.array([1.0, -0.8, 0.5])
FLOOR = {"flow": 1.0, "other_flow": 1.0}
KNOWN, OPEN = 1e-4 * np.eye(3), np.diag([25.0, 1e-4, 1e-4])


class Later:
    """Another recording of such a loop, held out."""

    def __init__(self, acting=(), lost=False):
        self._loop = FirstOrder(BUILT, acting, seed=9)
        self._signals = dict(self._loop.signals[1])
        if lost:
            self._signals = {"other_flow": self._signals["other_flow"]}

    def signals(self):
        return [self._signals]

    def mask(self):
        return counted

    def open_begins(self):
        return [0]

    def run(self, theta, acting, begin=None, roughly=False):
        return [self._loop.run_one(1, theta, acting)]


def asked(acting, later, covariance=KNOWN, least=2.0, theta=BUILT):
    return surprises(FirstOrder(BUILT, acting, seed=4), later, FLOOR, theta, covariance, least)


def test_a_rig_as_commissioned_surprises_nobody():
    assert asked([], Later()) == []
    everything = asked([], Later(), least=0.0)
    assert {one.signal for one in everything} == set(FLOOR)
    assert all(one.ratio == pytest.approx(1.0, abs=0.15) for one in everything)


def test_what_has_changed_since_surprises():
    change = [(EFFECTS[0], 0, 0.2)]
    worst = asked(change, Later(change))[0]
    assert worst.ratio > 10.0 and worst.off > 3.0 and worst.expected == pytest.approx(1.0, abs=0.1)


def test_what_commissioning_left_open_explains_as_much():
    change = [(EFFECTS[0], 0, 0.2)]
    assert asked(change, Later(change), OPEN)[0].ratio < 0.5, "a gain that is 50 % uncertain may be 20 % off"


def test_a_change_that_one_of_both_shows_counts_by_half():
    change = [(EFFECTS[0], 0, 0.2)]
    both, one, field = asked(change, Later(change)), asked(change, Later()), asked(change, None)
    assert one[0].ratio == pytest.approx(0.5 * (field[0].ratio + 1.0), rel=0.05)
    assert one[0].ratio < both[0].ratio and one[0].off == field[0].off


def test_a_signal_that_held_out_data_lack_is_asked_of_the_field_alone():
    change = [(EFFECTS[0], 0, 0.2)]
    lost = {one.signal: one.ratio for one in asked(change, Later(change, lost=True))}
    assert lost["flow"] == {one.signal: one.ratio for one in asked(change, None)}["flow"]


def test_the_same_question_has_the_same_answer():
    change = [(EFFECTS[0], 0, 0.2)]
    assert asked(change, Later(change), OPEN) == asked(change, Later(change), OPEN)


def test_where_a_drawn_run_goes_astray_nothing_is_said():
    change = [(EFFECTS[0], 0, 0.2)]
    loop = FirstOrder(BUILT, change, seed=4)
    run_one = loop.run_one
    loop.run_one = lambda number, theta, acting=(): run_one(number, theta if theta[0] < 1.5 else theta * np.nan, acting)
    assert all(one.ratio == 0.0 for one in surprises(loop, None, FLOOR, BUILT, OPEN, 2.0))


@pytest.mark.parametrize(("ratio", "least", "most"), [(1.0, 0.0, 0.001), (2.45, 0.0, 0.05), (4.8, 0.95, 1.0)])
def test_what_the_rig_as_commissioned_would_not_show_is_not_shown_by_it(ratio, least, most):
    probability, note = something_acts([Surprise("temperature/motor_housing", ratio, 3.0, 1.5), Surprise("speed", 1.0, 1.0, 1.0)])
    assert least <= probability <= most and (most < 0.5 or "temperature/motor_housing is 3.0 times its floor off" in note)


def test_a_field_recording_alone_has_to_surprise_more():
    off = [Surprise("temperature/motor_housing", 4.8, 3.0, 1.5)]
    assert something_acts(off)[0] > 0.95 and something_acts(off, alone=True)[0] < 0.05
    assert something_acts([Surprise("temperature/motor_housing", 7.0, 4.0, 1.5)], alone=True)[0] > 0.95


def test_where_nothing_was_worth_asking_nothing_acts():
    assert something_acts([]) == (0.0, "") and 1.0 < UNSURPRISING < SURPRISED


def test_one_number_that_is_open_of_the_rig_surprises_by_its_square():
    known, open_ = (Surprise("temperature/motor_housing", 3.8, off, expected) for off, expected in ((2.0, 1.05), (5.0, 2.5)))
    assert something_acts([known])[0] > 0.95 and something_acts([open_])[0] < 0.01
    assert "2.0 times its floor" in something_acts([open_, known])[1]
