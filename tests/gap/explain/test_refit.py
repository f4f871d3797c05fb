"""Fits of hypotheses in full."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.effect import Beside, added
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.refit import Refit
from support.first_order import EFFECTS, FirstOrder


@pytest.mark.parametrize("value", [np.nan, 1.0e200])
def test_a_start_from_which_runs_go_astray_does_not_dismiss_the_hypothesis(value):
    """Whether they end in what is no number or in what is too large for its square."""
    true = 0.15
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[0], 0, true)])
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, EFFECTS), np.zeros(3), pool)
    start, run_one = np.array([2.0, 2.0, 2.0]), model.run_one

    def astray(number, theta, acting=()):
        found = run_one(number, theta, acting)
        return {name: np.full_like(values, value) for name, values in found.items()} if np.array_equal(theta, start) else found

    model.run_one = astray
    column = next(c for c in linearised.columns if c.effect is EFFECTS[0])
    fitted = Refit(linearised).of([column], start, np.array([1.0]))
    assert np.isfinite(fitted.log_evidence) and fitted.x[0] == pytest.approx(true, abs=0.05)


GAIN = replace(EFFECTS[0], beside=Beside(lambda record, z: added("other_zero")(record, 0.05 * z), math.sqrt(3.0),
                                         lambda record: float(record["other_zero"][0]), ""))


def _fitted(model, effects, of):
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, effects), np.zeros(3), pool)
    column = next(c for c in linearised.columns if c.effect is of and c.x > 0.0)
    return Refit(linearised).of([column], np.zeros(3), np.array([1.0]))


def test_what_changed_along_with_an_effect_is_fitted_beside_it_and_no_part_of_its_size():
    """A valve whose gain departs, on the day that somebody moved the zero of the other meter: the gain alone takes the zero for itself."""
    true, changed = 0.15, 1.2
    model = FirstOrder(np.zeros(3), [(GAIN.along_with(changed), 0, true)])
    alone, beside = _fitted(model, EFFECTS, EFFECTS[0]), _fitted(model, [GAIN, *EFFECTS[1:]], GAIN)
    assert beside.beside[0] == pytest.approx(changed, abs=0.1) and beside.x[0] == pytest.approx(true, abs=0.01)
    assert beside.chi_square < alone.chi_square - 10.0 and beside.log_evidence > alone.log_evidence
    assert beside.joint.shape == alone.joint.shape  # of parameters and sizes alone
    again = model.run(beside.theta, beside.acting)[1]
    assert all(np.array_equal(again[name], was) for name, was in beside.predictions[1].items())  # as it acts is as it was fitted


def test_what_may_change_beside_an_effect_goes_no_further_than_its_end_and_adds_to_the_deviation():
    far = FirstOrder(np.zeros(3), [(GAIN.along_with(5.0), 0, 0.15)])
    assert _fitted(far, [GAIN, *EFFECTS[1:]], GAIN).beside[0] <= math.sqrt(3.0)
    none = FirstOrder(np.zeros(3), [(GAIN, 0, 0.15)])
    of_one, of_both = _fitted(none, EFFECTS, EFFECTS[0]), _fitted(none, [GAIN, *EFFECTS[1:]], GAIN)
    assert abs(of_both.beside[0]) < 0.2
    assert of_both.covariance[0, 0] >= of_one.covariance[0, 0] * (1.0 - 1e-6)


def test_where_no_recording_shows_the_rig_before_nothing_changes_beside_an_effect():
    """The rig's own parameters say how it is then."""
    model = FirstOrder(np.zeros(3), [(GAIN.along_with(1.2), 0, 0.15)])
    model.altered = [True, True]
    assert not _fitted(model, [GAIN, *EFFECTS[1:]], GAIN).beside.any()


def test_beside_a_bound_an_effect_is_looked_at_the_other_way():
    """A departure that ends a rounding short of its bound has no room there, and a difference over a rounding is no sensitivity."""
    model = FirstOrder(np.zeros(3), [(EFFECTS[0], 0, 0.6)], seed=21, seconds=(30.0, 30.0))
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, [replace(EFFECTS[0], highest=0.3)]), np.zeros(3), pool)
    column = next(c for c in linearised.columns if c.x > 0.0)
    at, short = (replace(column, effect=replace(column.effect, highest=end)) for end in (0.3, np.nextafter(0.3, 1.0)))
    fits = [Refit(linearised).of([own], np.zeros(3), np.array([0.3 / column.x])) for own in (at, short)]
    assert fits[0].covariance[0, 0] == pytest.approx(fits[1].covariance[0, 0], rel=1e-6)
    assert fits[0].log_evidence == pytest.approx(fits[1].log_evidence, abs=1e-3)


def test_a_wide_prior_of_sizes_is_wide_in_the_evidence_too():
    """How large a large effect is costs no more than its chi-square where any size is as likely."""
    model = FirstOrder(np.zeros(3), [(EFFECTS[1], 0, 4.0)], seed=3)
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, EFFECTS), np.zeros(3), pool)
    column = next(c for c in linearised.columns if c.effect is EFFECTS[1] and c.x > 0.0)
    fitted = Refit(linearised, width=10.0).of([column], np.zeros(3), np.array([1.0]))
    multiples = fitted.x[0] / column.x
    assert multiples > 5.0
    assert fitted.log_evidence > -0.5 * fitted.chi_square - 0.5 * (multiples / 10.0) ** 2 - 15.0


class Exponential(FirstOrder):
    """The same loop whose gain grows threefold with every unit of what was the other meter's zero."""

    def run_one(self, number, theta, acting=(), roughly=False):
        gained = 3.0 ** self.record(number, theta, acting)[0]["other_zero"]
        return {name: gained * flow for name, flow in super().run_one(number, theta).items()}


def test_a_fit_that_still_gains_much_goes_on():
    true = 2.0
    model = Exponential(np.zeros(3), [(EFFECTS[2], 0, true)])
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, EFFECTS[2:]), np.zeros(3), pool)
    column = next(c for c in linearised.columns if c.x > 0.0)
    fitted = Refit(linearised).of([column], np.zeros(3), np.array([1.0]))
    assert fitted.x[0] == pytest.approx(true, rel=0.01)
