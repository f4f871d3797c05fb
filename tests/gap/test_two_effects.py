"""Two effects that explain a recording together."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.refit import Refitted
from ddh_twin_py.gap.sensitivity import Column
from ddh_twin_py.gap.two_effects import CANCEL_DOUBT, DOUBT, cancelling, doubted
from ddh_twin_py.gap.unknown import Unknown
from support.first_order import EFFECTS

COLUMNS = [Column(effect, 0, 0.1, 5.0, "flow", []) for effect in EFFECTS]
NOTHING = Unknown(0.01, [], 0.0, "1")


def linearised(likeness):
    information = np.array([[100.0, likeness * 100.0, 0.0], [likeness * 100.0, 100.0, 0.0], [0.0, 0.0, 100.0]])
    return SimpleNamespace(columns=COLUMNS, evidence=SimpleNamespace(sums=SimpleNamespace(information=information)))


def fitted(*departures):
    x = 0.1 * np.array(departures)
    return Refitted(tuple(COLUMNS[: x.size]), x, np.eye(x.size), np.eye(x.size), np.zeros(0), [], 0.0, 0.0)


@pytest.mark.parametrize("likeness, share", [(0.0, 0.0), (0.5, 0.0), (-0.5, 0.5), (-0.9, 0.9)])
def test_share_of_two_that_cancels(likeness, share):
    assert cancelling(linearised(likeness), fitted(1.0, 1.0)) == pytest.approx(share)


def test_two_effects_are_less_sure_than_one_and_two_that_cancel_less_still():
    one, two, against = (doubted(NOTHING, linearised(likeness), leader) for likeness, leader in (
        (-0.9, fitted(1.0)), (0.1, fitted(1.0, 1.0)), (-0.6, fitted(1.0, 1.0))))
    assert one is NOTHING
    assert (two.probability, two.notes) == (DOUBT, [])
    assert against.probability == CANCEL_DOUBT and "cancel 60%" in against.notes[0]
