"""The size of an effect is as sure as what it is counted from."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.departure import departure_of
from ddh_twin_py.gap.explain.refit import Refitted
from support.first_order import DEVIATION, EFFECTS, RECORD, FirstOrder

GAIN, LAG, OFFSET = EFFECTS
SURE = 1.0e-6
PARAMETERS, LAW = 0.35, 0.1  # shares by which laws may misjudge


def fitted(effect, x, spread, law_error=0.0):
    """One effect beside parameters with independent deviations ``spread`` (3,)."""
    joint = np.diag([*np.square(spread), SURE**2])
    column = Column(replace(effect, law_error=law_error), 0, 1.0, 5.0, "flow", [])
    return Refitted((column,), np.array([x]), joint[3:, 3:], joint, np.array([0.2, 0.5, 0.0]), [], 0.0, 0.0, np.zeros(1))


def test_a_value_counted_from_a_parameter_is_no_surer_than_that():
    model = FirstOrder([0.0, 0.0, 0.0])
    value, std, unit, nominal = departure_of(model, fitted(LAG, 0.3, [0.1, 0.4, 0.1]), 0)
    built = RECORD["lag"][0] + 0.5 * DEVIATION[1]
    assert (value, nominal, unit) == (pytest.approx(built + 0.3), pytest.approx(built), "s")
    assert std == pytest.approx(DEVIATION[1] * np.hypot(0.4, PARAMETERS), rel=1e-3)


def test_what_a_law_may_misjudge_goes_with_the_departure():
    model = FirstOrder([0.0, 0.0, 0.0])
    assert departure_of(model, fitted(GAIN, 0.3, [0.1, 0.1, 0.1], LAW), 0)[1] == pytest.approx(LAW * 0.3, rel=1e-3)
    assert departure_of(model, fitted(OFFSET, 0.02, [0.1, 0.1, 0.1]), 0)[1] == pytest.approx(SURE, rel=1e-3)
    into_a_frame = fitted(replace(GAIN, unsteady=0.5), 0.3, [0.1, 0.1, 0.1], LAW)
    assert departure_of(model, into_a_frame, 0)[1] == pytest.approx(np.hypot(LAW, 0.5) * 0.3, rel=1e-3)


def test_without_commissioning_the_rigs_own_parameter_is_part_of_the_value():
    model = FirstOrder([0.0, 0.0, 0.0])
    model.altered = [True, True]
    value, std, _, nominal = departure_of(model, fitted(GAIN, 0.3, [0.1, 0.1, 0.1]), 0)
    ratio = 1.0 + 0.2 * DEVIATION[0]
    assert (value, nominal) == (pytest.approx(1.3 * ratio), 1.0)
    assert std == pytest.approx(1.3 * DEVIATION[0] * np.hypot(0.1, PARAMETERS), rel=1e-3)
