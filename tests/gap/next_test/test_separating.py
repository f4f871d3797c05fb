"""How far a test would tell hypotheses apart."""

import numpy as np
import pytest
from ddh_twin_py.gap.effect import Effect, added, fixed
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.next_test.separating import Believed, Trial

BOUNDED = Effect("a.b", "a", "hydraulic", "p", "1", fixed(0.0), (added("f"),), 0.1, -1.0, 1.0)


class Sums(Trial):
    """Reads the sum of all departures."""

    def predict(self, theta, acting):
        raise NotImplementedError

    def features(self, theta, acting):
        return np.array([sum(x for *_, x in acting), 0.0])


@pytest.mark.parametrize("x", [0.0, 0.97, 1.0, -0.97, -1.0])
def test_a_departure_is_as_open_at_its_bound_as_within(x):
    columns = (Column(BOUNDED, 0, 0.1, 5.0, "flow", []),)
    belief = Believed(("a.b",), np.zeros(1), columns, np.array([x]), np.array([[0.04]]), np.zeros(1))
    assert np.abs(Sums({}, None).of_departures(belief)[:, 0]) == pytest.approx([0.2, 0.0])


def test_of_two_departures_at_their_bounds_what_both_can_do_is_open():
    columns = (Column(BOUNDED, 0, 0.1, 5.0, "flow", []), Column(BOUNDED, 0, 0.1, 5.0, "flow", []))
    belief = Believed(("a.b", "a.b"), np.zeros(1), columns, np.array([1.0, 1.0]), np.array([[0.04, 0.03], [0.03, 0.04]]), np.zeros(2))
    free = Sums({}, None).of_departures(belief)
    assert np.max(np.abs(free[0])) == pytest.approx(np.sqrt(0.07) * np.sqrt(2.0)) and np.isfinite(free).all()
