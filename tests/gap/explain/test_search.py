"""The search on a rig that is not the direct driven unit: all it needs of a rig is the protocol `gap.model.Model`."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.search import search
from support.first_order import DEVIATION, EFFECTS, FirstOrder

TRUE = np.array([1.0, -0.8, 0.5])


def found(model, effects=EFFECTS, progress=None):
    with ThreadPoolExecutor(2) as pool:
        return search(Question(model, effects), np.zeros(3), pool, progress)


@pytest.mark.parametrize("index, departure", [(0, 0.15), (0, -0.15), (1, 0.4), (2, 0.12), (2, -0.12)])
def test_the_effect_that_acts_is_found_with_its_size(index, departure):
    result = found(FirstOrder(TRUE, [(EFFECTS[index], 0, departure)], seed=index))
    assert result.leader == (EFFECTS[index].id,) and result.probability[result.leader] > 0.8
    fitted = result.fitted[result.leader]
    std = float(np.sqrt(fitted.covariance[0, 0]))
    assert abs(fitted.x[0] - departure) < 3.0 * std and std < 0.3 * abs(departure)
    assert np.abs((fitted.theta - TRUE) * DEVIATION).max() < 0.05
    assert fitted.chi_square < result.fitted[()].chi_square


def test_two_effects_at_once():
    result = found(FirstOrder(TRUE, [(EFFECTS[1], 0, 0.5), (EFFECTS[2], 0, 0.15)], seed=5))
    assert result.leader == ("meter.offset", "valve.lag")
    assert result.fitted[result.leader].effects == result.leader


@pytest.mark.parametrize("law_error, effects", [(0.0, 2), (0.3, 1)])
def test_what_the_law_of_the_first_may_misjudge_is_no_second_effect(law_error, effects):
    model = FirstOrder(TRUE, [(EFFECTS[0], 0, 0.3)], seed=5)
    doing = model.run_one(1, TRUE, [(EFFECTS[0], 0, 0.3)])["other_flow"] - model.run_one(1, TRUE)["other_flow"]
    read = model.signals[1]["other_flow"]  # the gain does more to it in one direction, which an offset does in part
    model.signals[1]["other_flow"] = replace(read, measured=read.measured + 0.5 * np.maximum(doing, 0.0))
    assert len(found(model, [replace(effect, law_error=law_error) for effect in EFFECTS]).leader) == effects


def test_a_second_effect_is_one_however_free_the_law_of_the_first():
    model = FirstOrder(TRUE, [(EFFECTS[1], 0, 0.5), (EFFECTS[2], 0, 0.15)], seed=5)  # no lag makes up for an offset
    assert found(model, [replace(effect, law_error=0.3) for effect in EFFECTS]).leader == ("meter.offset", "valve.lag")


def test_none_is_none():
    assert [found(FirstOrder(TRUE, seed=seed)).leader for seed in range(4)] == [()] * 4


def test_one_that_is_not_asked_about_is_not_named():
    """The true effect left out: no other one is told with the certainty that the true one has."""
    model = FirstOrder(TRUE, [(EFFECTS[2], 0, 0.12)], seed=2)
    with_it, without = found(model), found(model, EFFECTS[:2])
    assert all("meter.offset" not in ids for ids in without.probability)
    best = without.fitted[without.leader]
    assert best.log_evidence < with_it.fitted[with_it.leader].log_evidence - 5.0


def test_nothing_to_ask_about():
    result = found(FirstOrder(TRUE, seed=1), [])
    assert result.probability == {(): 1.0} and list(result.fitted) == [()]


def test_probabilities_sum_to_one_and_progress_ends_at_one():
    shares = []
    result = found(FirstOrder(TRUE, [(EFFECTS[0], 0, 0.15)]), progress=shares.append)
    assert sum(result.probability.values()) == pytest.approx(1.0) and () in result.probability
    assert shares[-1] == 1.0 and min(shares) >= 0.0 and max(shares) <= 1.0


def test_the_same_recordings_twice_give_the_same_answer():
    model = FirstOrder(TRUE, [(EFFECTS[1], 0, 0.4)], seed=3)
    assert found(model).probability == found(model).probability


class Sticking(FirstOrder):
    """Its runs go astray where the offset acts on a loop that is as its sheet says, as those of a rod that is pressed into a stop."""

    def run_one(self, number, theta, acting=(), roughly=False):
        out = super().run_one(number, theta, acting, roughly)
        astray = self.altered[number] and any(effect is EFFECTS[2] for effect, _, _ in acting) and np.abs(theta).max() < 0.3
        return {name: y + 1.0e12 for name, y in out.items()} if astray else out


def test_an_effect_with_which_runs_went_astray_at_one_place_is_asked_about_at_the_next():
    result = found(Sticking(TRUE, [(EFFECTS[2], 0, 0.2)], seed=2))
    assert result.leader == ("meter.offset",) and result.probability[result.leader] > 0.8


@pytest.mark.parametrize("departure", [1.0, 3.0])
def test_what_scatters_where_the_linear_model_bends_is_no_noise_beside_the_fits(departure):
    """A lag that is grown several times: no line follows it, and what it leaves would hide the truth among the noise."""
    result = found(FirstOrder(np.zeros(3), [(EFFECTS[1], 0, departure)], seed=3))
    assert result.leader == ("valve.lag",) and result.probability[result.leader] > 0.99
    left, known = result.linearised.scatter_beside(result.fitted[result.leader].predictions), result.linearised.discrepancy.scatter
    assert max(known[name] / own for name, own in left.items()) < 1.3


@pytest.mark.parametrize(("departure", "index", "seed"), [(2.0, 2, 3), (3.0, 2, 4), (2.0, 0, 3), (1.0, 0, 4)])
def test_a_second_effect_is_found_beside_a_large_one_that_bends(departure, index, seed):
    true = {EFFECTS[1].id: departure, EFFECTS[index].id: 0.05}
    result = found(FirstOrder(np.zeros(3), [(EFFECTS[1], 0, departure), (EFFECTS[index], 0, 0.05)], seed=seed))
    assert result.leader == tuple(sorted(true)) and result.probability[result.leader] > 0.9
    fitted = result.fitted[result.leader]
    for effect, _, x in fitted.acting:
        assert abs(x - true[effect.id]) < max(0.005, 0.01 * departure)
