"""Which hypotheses are fitted in full."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.fits import Fits, Start
from ddh_twin_py.gap.explain.worth import Learnt
from support.first_order import EFFECTS, FirstOrder


def ranked(model, pool, theta=(0.0, 0.0, 0.0)):
    """A model's linearisation about parameters (3,), and the weights of every set of effects by it."""
    linearised = linearise(Question(model, EFFECTS), np.array(theta), pool)
    return linearised, linearised.weights()


def stand(fits, fitted):
    """Let other sets stand for those that were fitted."""
    fits.fitted.clear()
    fits.fitted.update(fitted)


@pytest.mark.parametrize("index, departure", [(0, 0.15), (2, 0.12)])
def test_what_fell_short_elsewhere_is_fitted_before_it_is_dismissed(index, departure):
    model, true = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[index], 0, departure)], seed=index), (EFFECTS[index].id,)
    with ThreadPoolExecutor(2) as pool:
        linearised, weights = ranked(model, pool)
        fits = Fits(linearised, weights, pool, Learnt(short={EFFECTS[index].id: -1000.0}))
        fits.leaders()
        assert true in fits.fitted and next(iter(fits.probability())) == true


def test_what_is_left_of_a_set_with_an_effect_too_slight_to_be_one_is_fitted():
    acts, slight = EFFECTS[1], EFFECTS[0]
    model, pair = FirstOrder(np.array([1.0, -0.8, 0.5]), [(acts, 0, 0.3)], seed=1), tuple(sorted((acts.id, slight.id)))
    with ThreadPoolExecutor(2) as pool:
        linearised, weights = ranked(model, pool)
        fits = Fits(linearised, weights, pool, Learnt(short={acts.id: -1000.0}))
        fits.again({(): Start(np.zeros(3), np.zeros(0)), (slight.id,): Start(np.zeros(3), np.array([0.1]))})
        of = Fits(linearised, weights, pool)
        of.again({pair: Start(np.zeros(3), np.array([0.3 if name == acts.id else 1e-6 for name in pair]))})
        both = of.fitted[pair]
        nearly_none = [x if c.effect.id == acts.id else 1e-9 * x for c, x in zip(both.columns, both.x, strict=True)]
        alone = fits.fitted[(slight.id,)]
        high = both.log_evidence + 50.0  # so that the slight one seems to be what explains most of the pair
        fits.fitted |= {pair: replace(both, x=np.array(nearly_none), log_evidence=high), (slight.id,): replace(alone, log_evidence=high)}
        assert fits.fitted[pair].slight == {slight.id} and (acts.id,) not in fits.fitted
        fits.probability()
    assert fits.fitted[(acts.id,)].x == pytest.approx([0.3], abs=0.05)


def test_a_fit_that_lost_its_way_is_found_again_with_sensitivities_of_its_own():
    model, true = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[1], 0, 1.5)], seed=1), (EFFECTS[1].id,)
    with ThreadPoolExecutor(2) as pool:
        linearised, weights = ranked(model, pool)
        fits = Fits(linearised, weights, pool)
        fits.leaders()
        found = fits.fitted[true]
        promised = fits.worth.linear(true)
        fitted = fits.fitted
        stand(fits, {**fitted, (): replace(fitted[()], log_evidence=fitted[()].log_evidence + 2.0 * max(10.0, 0.05 * promised))})
        assert not fits.fell_short(), "that no effect does better than the linear model knows is no fault of the fit"
        fits.fitted = fitted
        lost = min(found.log_evidence, linearised.evidence.log_of_none + promised) - 2.0 * max(10.0, 0.05 * promised)
        astray = replace(found, x=0.5 * found.x, theta=found.theta + 1.0, log_evidence=lost)
        stand(fits, {(): fits.fitted[()], true: replace(astray, predictions=model.run(astray.theta, astray.acting))})
        assert fits.fell_short()
        fits.sharpen()
    assert fits.fitted[true].log_evidence > found.log_evidence - 0.5
    np.testing.assert_allclose(fits.fitted[true].x, found.x, rtol=0.05)


def test_of_two_near_rivals_that_stopped_on_the_way_the_better_one_is_found():
    model, true, other = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[1], 0, 1.5)], seed=1), (EFFECTS[1].id,), (EFFECTS[0].id,)
    with ThreadPoolExecutor(2) as pool:
        linearised, weights = ranked(model, pool)
        fits = Fits(linearised, weights, pool)
        fits._fit([(), true, other])
        found, rival = fits.fitted[true], fits.fitted[other]
        none = replace(fits.fitted[()], log_evidence=found.log_evidence - 500.0)
        astray = replace(found, x=0.7 * found.x, log_evidence=found.log_evidence - 8.0)
        ahead = replace(rival, log_evidence=found.log_evidence - 4.0)
        alone = {(): none, true: replace(astray, predictions=model.run(astray.theta, astray.acting))}
        stand(fits, {**alone, other: replace(ahead, log_evidence=none.log_evidence + 1.0)})
        fits.sharpen()
        assert fits.fitted[true].log_evidence == astray.log_evidence, "where no rival is near nothing is decided by it"
        stand(fits, {**alone, other: ahead})
        fits.sharpen()
    assert fits.fitted[true].log_evidence > found.log_evidence - 0.5
    np.testing.assert_allclose(fits.fitted[true].x, found.x, rtol=0.05)


def test_where_the_linear_model_misjudges_no_effect_others_are_judged_as_elsewhere():
    """About where an effect acts, sets without it mend what no effect lacks at that place alone."""
    true, other, third = (effect.id for effect in (EFFECTS[1], EFFECTS[0], EFFECTS[2]))
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[1], 0, 0.3)], seed=1)
    unrelated = tuple(sorted((other, third)))
    with ThreadPoolExecutor(2) as pool:
        linearised, weights = ranked(model, pool)

        def fits_after(before):
            fits = Fits(linearised, weights, pool, before)
            fits.again({(): Start(np.zeros(3), np.zeros(0)), (true,): Start(np.zeros(3), np.array([0.3]))})
            # as where the linear model is taken about a place that no effect is far from
            stand(fits, {ids: replace(f, log_evidence=f.log_evidence + 500.0) for ids, f in fits.fitted.items()})
            return fits

        known = fits_after(Learnt(expected={unrelated: -9.0}, off=1.0))
        unknown = fits_after(None)
    assert (known.worth.learnt().expected, known.worth.learnt().off) == ({unrelated: -9.0}, 1.0) and unknown.worth.learnt().off > 400.0
    assert known.probability()[unrelated] < 1e-3
    promised = linearised.evidence.log_of_none + known.worth.linear((true,))
    assert known.worth.bent((true,)) == pytest.approx(abs(known.fitted[(true,)].log_evidence - promised))


def test_sets_that_nobody_fitted_do_not_outweigh_those_that_were():
    true, model = (EFFECTS[1].id,), FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[1], 0, 0.3)], seed=1)
    with ThreadPoolExecutor(2) as pool:
        linearised, weights = ranked(model, pool)
        promising = {ids: (weight + 1000.0 * (ids not in ((), true)), way) for ids, (weight, way) in weights.items()}
        fits = Fits(linearised, promising, pool)
        fits.again({(): Start(np.zeros(3), np.zeros(0)), true: Start(np.zeros(3), np.array([0.3]))})
        rest = [ids for ids in fits.probability() if ids not in fits.fitted]
        assert sum(fits.probability()[ids] for ids in rest) > 0.5
        fits.settle()
        assert sum(p for ids, p in fits.probability().items() if ids not in fits.fitted) <= 0.1


def _judged(changed, by_freedom):
    """Log weights of fits whose log evidence over no effect is ``changed``, where free laws gain ``by_freedom`` (a single, a set)."""
    model = FirstOrder(np.array([1.0, -0.8, 0.5]), [(EFFECTS[0], 0, 0.15)], seed=1)
    with ThreadPoolExecutor(2) as pool:
        linearised, weights = ranked(model, pool)
        fits = Fits(linearised, weights, pool)
        fits.again({(): Start(np.zeros(3), np.zeros(0)), **{ids: Start(np.zeros(3), np.full(len(ids), 0.1)) for ids in changed}})
        none = fits.fitted[()].log_evidence
        stand(fits, {ids: replace(f, log_evidence=none + changed.get(ids, 0.0)) for ids, f in fits.fitted.items()})
        fits._owed._law_error = dict.fromkeys(fits._owed._law_error, 0.1)
        fits._owed._freed = lambda asked, fitted: by_freedom
        return fits, fits._judged()


def test_a_pair_is_not_held_against_another_by_how_badly_its_first_effect_does_alone():
    gain, lag, zero = ((effect.id,) for effect in (EFFECTS[0], EFFECTS[1], EFFECTS[2]))
    true, mimic = tuple(sorted(gain + zero)), tuple(sorted(lag + zero))
    evidence = {gain: 1127.0, lag: 1280.0, zero: 1086.0, true: 1622.0, mimic: 1587.0}
    freedom = {(gain, gain): 129.0, (gain, true): 8.0, (lag, lag): 46.0, (lag, mimic): 28.0}
    fits, weight = _judged(evidence, freedom)
    assert weight[true] - weight[mimic] == pytest.approx(1622.0 + 8.0 - 1587.0 - 28.0, abs=0.1)
    assert fits.worth.full(lag) < weight[mimic] < fits.worth.full(mimic)


def test_a_second_effect_that_only_mends_the_law_of_the_first_is_not_believed():
    gain, lag, zero = ((effect.id,) for effect in (EFFECTS[0], EFFECTS[1], EFFECTS[2]))
    mends, other = tuple(sorted(gain + zero)), tuple(sorted(gain + lag))
    evidence = {gain: 1000.0, lag: 10.0, zero: 5.0, mends: 1030.0, other: 1028.0}
    fits, weight = _judged(evidence, {(gain, gain): 41.0, (gain, mends): 3.0, (gain, other): 0.0})
    assert max(weight, key=weight.get) == gain
    assert weight[mends] == pytest.approx(fits.worth.full(mends) - 38.0)
