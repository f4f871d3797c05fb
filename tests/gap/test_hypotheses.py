"""Evidence of sets of effects on linear problems whose answer is known."""

import numpy as np
import pytest
from ddh_twin_py.estimation.linear_gaussian import Gram, Marginal, gain
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.hypotheses import Evidence, probabilities, weighted
from ddh_twin_py.gap.sensitivity import Column
from scipy.stats import multivariate_normal

NAMES = list(EFFECTS)[:5]


def problem(seed, true, parameters=4, rows=400):
    """Columns of parameters and effects, and data in which `true` maps effects to departures."""
    rng = np.random.default_rng(seed)
    x = rng.normal(size=(rows, parameters + len(NAMES))) * 0.4
    theta = rng.normal(size=parameters)
    y = x[:, :parameters] @ theta + rng.normal(size=rows)
    for i, departure in true.items():
        y += departure * x[:, parameters + i]
    columns = [Column(EFFECTS[name], 0, 1.0, 5.0, "speed", []) for name in NAMES]
    return Evidence(Gram.of(x, y), parameters, np.zeros(parameters), columns), columns, x, y


def test_evidence_is_that_of_the_whole_gaussian():
    """Log evidence gained, against the density of the data with everything integrated out."""
    evidence, _, x, y = problem(0, {1: 1.0}, rows=40)

    def density(chosen):
        covariance = np.eye(40) + x[:, :4] @ x[:, :4].T
        for i in chosen:
            covariance += evidence.prior[i] ** 2 * np.outer(x[:, 4 + i], x[:, 4 + i])
        return multivariate_normal(np.zeros(40), covariance).logpdf(y)

    marginal = Marginal(Gram.of(x, y), np.arange(4))
    for chosen in ([1], [0, 3]):
        information, score = marginal.project(4 + np.array(chosen))
        log, _, _ = gain(information, score, evidence.prior[chosen])
        assert log == pytest.approx(density(chosen) - density([]), abs=1e-8)


@pytest.mark.parametrize("true", [{}, {2: 2.0}, {1: 2.0, 4: 1.5}])
def test_the_true_set_comes_first(true):
    found = 0
    for seed in range(20):
        evidence, columns, _, _ = problem(seed, true)
        singles = evidence.singles()
        weights = weighted(singles + evidence.pairs(singles), columns, len(NAMES))
        first = next(iter(probabilities({ids: w for ids, (w, _) in weights.items()})))
        found += first == tuple(sorted(NAMES[i] for i in true))
    assert found >= 18


def test_a_departure_against_its_direction_is_no_evidence():
    evidence, columns, _, _ = problem(3, {2: -2.0})
    assert evidence.of([2]).log_evidence < 0.0
