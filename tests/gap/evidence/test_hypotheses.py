"""Evidence of sets of effects on linear problems whose answer is known."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.linear_gaussian import gain
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.evidence.basis import Sums
from ddh_twin_py.gap.evidence.box import Normal
from ddh_twin_py.gap.evidence.hypotheses import (
    LEAST,
    PRIOR_NONE,
    PRIOR_PAIRS,
    WIDTH,
    WIDTHS,
    Evidence,
    Hypothesis,
    probabilities,
    slack_shares,
    way_shares,
    weigh,
    weighted,
)
from ddh_twin_py.gap.evidence.sensitivity import Column
from scipy.integrate import dblquad, quad
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, norm

NAMES = list(EFFECTS)[:5]
FREE = {name: replace(EFFECTS[name], lowest=-math.inf, highest=math.inf) for name in NAMES}
PARAMETERS = 4


def problem(seed, true, rows=400):
    """Evidence, columns and data in which `true` maps effects to departures; parameters are integrated out."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(rows, PARAMETERS + len(NAMES))) * 0.4
    y = x[:, :PARAMETERS] @ rng.normal(size=PARAMETERS) + rng.normal(size=rows)
    for i, departure in true.items():
        y += departure * x[:, PARAMETERS + i]
    own = x[:, PARAMETERS:]
    marginal = np.linalg.inv(np.eye(rows) + x[:, :PARAMETERS] @ x[:, :PARAMETERS].T)
    columns = [Column(FREE[name], 0, 1.0, 5.0, "speed", []) for name in NAMES]
    shared, ends = x[:, :PARAMETERS], np.full(PARAMETERS, 100.0)
    normal = Normal(shared.T @ shared + np.eye(PARAMETERS), shared.T @ y, shared.T @ own, own.T @ own, own.T @ y, float(y @ y), -ends, ends)
    return Evidence(Sums(own.T @ marginal @ own, own.T @ marginal @ y, float(y @ marginal @ y)), normal, columns), x, y


def test_gain_is_that_of_the_whole_gaussian():
    """Log evidence gained, against the density of the data with everything integrated out."""
    evidence, x, y = problem(0, {1: 1.0}, rows=40)

    def density(chosen):
        covariance = np.eye(40) + x[:, :PARAMETERS] @ x[:, :PARAMETERS].T
        for i in chosen:
            covariance += WIDTH**2 * np.outer(x[:, PARAMETERS + i], x[:, PARAMETERS + i])
        return multivariate_normal(np.zeros(40), covariance).logpdf(y)

    for chosen in ([1], [0, 3]):
        sums = evidence.sums
        log, _, _ = gain(sums.information[np.ix_(chosen, chosen)], sums.score[chosen], np.full(len(chosen), WIDTH))
        assert log == pytest.approx(density(chosen) - density([]), abs=1e-8)


def moment_prior(x):
    """Of a departure in one direction; it integrates to 1 from 0 to infinity."""
    return np.mean([2.0 * x**2 / width**2 * norm.pdf(x, scale=width) for width in WIDTHS])


@pytest.mark.parametrize("information, score, room", [(20.0, 30.0, math.inf), (20.0, 50.0, 6.0), (6.0, 14.0, math.inf)])
def test_weigh_of_one_is_the_integral_over_its_prior(information, score, room):
    exact, _ = quad(lambda x: moment_prior(x) * math.exp(score * x - 0.5 * information * x**2), LEAST, min(room, 12.0))
    log, estimate, covariance = weigh(np.array([[information]]), np.array([score]), np.array([room]))
    assert log == pytest.approx(math.log(exact), abs=0.001)
    precision = information + WIDTH**-2
    assert estimate[0] == pytest.approx(score / precision) and covariance[0, 0] == pytest.approx(1.0 / precision)


def test_a_faint_departure_is_not_held_for_less_likely_than_a_clear_one():
    """Of the same certainty: each has the evidence of its own width."""
    information = 400.0
    faint, clear = (weigh(np.array([[information]]), np.array([information * x]), np.array([math.inf]))[0] - 0.5 * information * x**2
                    for x in (0.44, 2.2))
    assert faint == pytest.approx(clear + math.log(5.0), abs=0.5)  # as likely, of a range a fifth as wide


def test_weigh_of_three_that_are_far_from_none_is_the_integral_over_all():
    """Where no bound cuts, the integral of the moment prior times the likelihood, by Gauss and Hermite exact for polynomials."""
    information = np.array([[40.0, 25.0, 12.0], [25.0, 50.0, 20.0], [12.0, 20.0, 45.0]])
    score = information @ np.array([2.0, 2.5, 3.0])
    logs = []
    for wide in itertools.product(WIDTHS, repeat=3):
        precision = information + np.diag(np.array(wide) ** -2.0)
        covariance = np.linalg.inv(precision)
        mean = covariance @ score
        nodes, weights = np.polynomial.hermite_e.hermegauss(4)
        points = mean + np.array(list(itertools.product(nodes, repeat=3))) @ np.linalg.cholesky(covariance).T
        shares = np.prod(np.array(list(itertools.product(weights / math.sqrt(2.0 * math.pi), repeat=3))), axis=1)
        prior = 8.0 * np.prod(points**2, axis=1) / np.prod(np.array(wide) ** 3.0) * math.sqrt(np.linalg.det(covariance))
        logs.append(math.log(shares @ prior) + 0.5 * mean @ score)
    exact = logsumexp(logs) - math.log(len(logs))
    assert weigh(information, score, np.full(3, math.inf))[0] == pytest.approx(exact, abs=0.01)


def test_weigh_of_two_is_the_integral_over_both():
    information, score = np.array([[20.0, 8.0], [8.0, 15.0]]), np.array([40.0, 35.0])

    def density(b, a):
        x = np.array([a, b])
        return moment_prior(a) * moment_prior(b) * math.exp(score @ x - 0.5 * x @ information @ x - 50.0)

    exact, _ = dblquad(density, LEAST, 5.0, LEAST, 5.0, epsabs=0.0, epsrel=1e-8)
    log, _, _ = weigh(information, score, np.array([math.inf, math.inf]))
    assert log == pytest.approx(math.log(exact) + 50.0, abs=0.03)


def test_an_estimate_stays_within_its_room_and_pays_for_it():
    free, _, _ = weigh(np.array([[20.0]]), np.array([40.0]), np.array([math.inf]))
    held, estimate, _ = weigh(np.array([[20.0]]), np.array([40.0]), np.array([0.5]))
    assert estimate[0] == 0.5 and held < free - 5.0


def test_nothing_seen_is_no_evidence():
    """Where the data say nothing the evidence is the share of the prior beyond the least departure."""
    log, estimate, _ = weigh(np.array([[0.0]]), np.array([0.0]), np.array([math.inf]))
    beyond, _ = quad(moment_prior, LEAST, math.inf)
    assert log == pytest.approx(math.log(beyond), abs=1e-6) and estimate[0] == 0.0


@pytest.mark.parametrize("room", [1.0, 2.0, math.inf])
@pytest.mark.parametrize("aim", [-6.0, -1.0, -0.1, 0.15, 0.9, 3.0])
@pytest.mark.parametrize("information", [25.0, 1000.0, 1.0e5])
def test_a_departure_against_its_bounds_pays_for_all_of_it(information, aim, room):
    """What data ask for far outside costs hundreds and thousands of nats, and none of them is lost."""
    best = min(max(aim, LEAST), room)
    spread = 1.0 / (information**0.5 + information * abs(best - aim))

    def log_density(x):
        return math.log(moment_prior(x)) + information * (aim * x - 0.5 * x**2)

    begin, end = max(LEAST, best - 20.0 * spread), min(room, best + 20.0 * spread)
    exact, _ = quad(lambda x: math.exp(log_density(x) - log_density(best)), begin, end, points=[best] if begin < best < end else None,
                    limit=400)
    log, estimate, _ = weigh(np.array([[information]]), np.array([information * aim]), np.array([room]))
    assert log == pytest.approx(math.log(exact) + log_density(best), abs=0.01) and estimate[0] <= room


@pytest.mark.parametrize("aim, room", [((-1.0, 2.0), (9.0, 9.0)), ((2.0, 2.5), (1.5, 9.0)), ((-0.5, -0.3), (9.0, 9.0))])
@pytest.mark.parametrize("correlated", [-0.8, 0.8])
def test_a_pair_of_which_one_goes_against_its_bounds_is_the_integral_over_both(aim, room, correlated):
    covariance = 0.15**2 * np.array([[1.0, correlated], [correlated, 1.0]])
    information = np.linalg.inv(covariance)
    score = information @ np.array(aim)
    x, y = (np.linspace(LEAST, min(end, 6.0), 2001) for end in room)
    prior = [np.log(np.mean([2.0 * z**2 / w**2 * norm.pdf(z, scale=w) for w in WIDTHS], axis=0)) for z in (x, y)]
    log_density = (prior[0][:, None] + prior[1] + score[0] * x[:, None] + score[1] * y
                   - 0.5 * information[0, 0] * x[:, None] ** 2 - 0.5 * information[1, 1] * y**2 - information[0, 1] * x[:, None] * y)
    exact = logsumexp(log_density) + math.log((x[1] - x[0]) * (y[1] - y[0]))
    log, _, _ = weigh(information, score, np.array(room))
    assert log == pytest.approx(exact, abs=0.2 + 0.02 * abs(exact))


@pytest.mark.parametrize("true", [{}, {2: 2.0}, {1: 2.0, 4: 1.5}])
def test_the_true_set_comes_first(true):
    found = 0
    for seed in range(20):
        evidence, _, _ = problem(seed, true)
        singles = evidence.singles()
        weights = weighted(singles + evidence.pairs(singles), evidence.columns, len(NAMES))
        first = next(iter(probabilities({ids: w for ids, (w, _) in weights.items()})))
        found += first == tuple(sorted(NAMES[i] for i in true))
    assert found >= 18


def test_a_departure_against_its_direction_is_no_evidence():
    evidence, _, _ = problem(3, {2: -2.0})
    assert evidence.of([2]).log_evidence < 0.0


def test_priors_of_sets_sum_to_one_whatever_ways_an_effect_has():
    """Two ways of the first effect share its prior; pairs of one effect's own ways are not tried."""
    ways = [(NAMES[0], 0), (NAMES[0], 1), (NAMES[1], 0), (NAMES[2], 0)]
    columns = [Column(FREE[name], law, 1.0, 5.0, "speed", []) for name, law in ways]
    normal = Normal(np.eye(1), np.zeros(1), np.zeros((1, 4)), np.eye(4), np.zeros(4), 0.0, -np.ones(1), np.ones(1))
    evidence = Evidence(Sums(np.eye(4), np.zeros(4), 0.0), normal, columns)
    singles = evidence.singles()
    pairs = evidence.pairs(singles)
    assert sorted(p.columns for p in pairs) == [(0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
    even = [Hypothesis(h.columns, 0.0, h.departure, h.spread, 0.0) for h in singles + pairs]
    weights = {ids: math.exp(w) for ids, (w, _) in weighted(even, columns, 3).items()}
    assert sum(weights.values()) == pytest.approx(1.0) and weights[()] == pytest.approx(PRIOR_NONE)
    assert weights[(NAMES[0],)] == pytest.approx(weights[(NAMES[1],)]) == pytest.approx((1.0 - PRIOR_NONE - PRIOR_PAIRS) / 3)
    assert sum(w for ids, w in weights.items() if len(ids) == 2) == pytest.approx(PRIOR_PAIRS)
    np.testing.assert_allclose(slack_shares(columns), [2**-0.5, 2**-0.5, 1.0, 1.0])


def test_an_effect_that_is_known_for_growing_seldom_shrinks():
    """One law in two directions, another law up alone; and an effect that goes either way."""
    wear, wrong = EFFECTS["pump_1.leakage"], EFFECTS["load.mass"]
    columns = [Column(wear, 0, 0.1, 5.0, "speed", []), Column(wear, 0, -0.1, 5.0, "speed", []),
               Column(wrong, 0, 3.0, 5.0, "speed", []), Column(wrong, 0, -3.0, 5.0, "speed", [])]
    np.testing.assert_allclose(way_shares(columns), [0.9, 0.1, 0.5, 0.5])
    np.testing.assert_allclose(way_shares(columns[1:]), [1.0, 0.5, 0.5])


def test_probabilities_are_normalised_and_sorted():
    found = probabilities({(): -1000.0, ("a",): -1001.0, ("b",): -990.0})
    assert list(found) == [("b",), (), ("a",)] and sum(found.values()) == pytest.approx(1.0)
