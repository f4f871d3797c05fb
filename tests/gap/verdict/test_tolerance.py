"""What is called no effect: what moves no signal by its noise."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.hypotheses import LEAST
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.refit import Refitted
from support.first_order import EFFECTS

VALVE, LAG, _ = EFFECTS


def fitted(*departures):
    columns = tuple(Column(effect, 0, x, 5.0, "flow", []) for effect, x in zip((VALVE, LAG), (0.1, -0.2), strict=False))
    x = np.array([d * c.x for d, c in zip(departures, columns, strict=False)])
    return Refitted(columns[: x.size], x, np.eye(x.size), np.eye(x.size + 3), np.zeros(3), [], 0.0, 0.0, np.zeros(x.size))


@pytest.mark.parametrize(("departures", "small"), [
    ((0.9 * LEAST,), {"valve.gain"}), ((1.1 * LEAST,), set()), ((2.0, 0.5 * LEAST), {"valve.lag"}), ((2.0, 2.0), set()), ((), set())])
def test_it_has_to_be_seen(departures, small):
    assert fitted(*departures).slight == small


def test_a_column_that_moves_little_is_no_measure():
    """Half of a column that moves the worst signal by two of its noise, instead of five, moves it by one."""
    found = fitted(0.45)
    little = replace(found, columns=(replace(found.columns[0], rise=2.0),))
    assert found.slight == set() and little.slight == {"valve.gain"}
