"""Sums of a hypothesis with parameters and slack integrated out, against dense algebra."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.weighting import Weighting
from ddh_twin_py.gap.evidence.basis import Basis
from support.made_comparison import comparisons, dense_allowances, split

PARAMETERS, SLACK, COLUMNS = 4, 3, 2
ENDS = np.full(PARAMETERS, 100.0)


@pytest.fixture(scope="module")
def case():
    made = comparisons(3)
    a = dense_allowances(made)
    covariance = np.eye(a.shape[0]) + a @ a.T
    rng = np.random.default_rng(4)
    f, c, y = (rng.normal(size=(a.shape[0], k)) for k in (PARAMETERS + SLACK, COLUMNS, 1))
    y = y[:, 0] + c @ [2.0, -1.0]
    basis = Basis(Weighting(made), split(made, f[:, :PARAMETERS]), split(made, f[:, PARAMETERS:]), -ENDS, ENDS)
    return basis, made, np.linalg.inv(covariance), f, c, y


def test_sums_are_those_of_the_marginal_gaussian(case):
    basis, made, p, f, c, y = case
    sums = basis.sums(split(made, c), split(made, y))
    marginal = np.linalg.inv(np.linalg.inv(p) + f @ f.T)
    np.testing.assert_allclose(sums.information, c.T @ marginal @ c, atol=1e-8)
    np.testing.assert_allclose(sums.score, c.T @ marginal @ y, atol=1e-8)
    assert sums.chi_square == pytest.approx(y @ marginal @ y, abs=1e-8)


def test_shared_unknowns_are_the_posterior_mean(case):
    basis, made, p, f, c, y = case
    x = np.array([1.5, -0.5])
    expected = np.linalg.solve(f.T @ p @ f + np.eye(f.shape[1]), f.T @ p @ (y - c @ x))
    np.testing.assert_allclose(basis.shared(split(made, c), split(made, y), x), expected, atol=1e-9)
    np.testing.assert_allclose(basis.covariance(), np.linalg.inv(f.T @ p @ f + np.eye(f.shape[1]))[:PARAMETERS, :PARAMETERS], atol=1e-10)


def test_misfit_integrates_the_slack_but_not_the_parameters(case):
    basis, made, p, f, _, y = case
    slack = f[:, PARAMETERS:]
    assert basis.misfit(split(made, y)) == pytest.approx(y @ np.linalg.inv(np.linalg.inv(p) + slack @ slack.T) @ y, abs=1e-8)


def test_misfits_of_rows_sum_to_it(case):
    basis, made, p, f, _, y = case
    slack = f[:, PARAMETERS:]
    expected = y * (np.linalg.inv(np.linalg.inv(p) + slack @ slack.T) @ y)
    np.testing.assert_allclose(np.concatenate(basis.misfits(split(made, y))), expected, atol=1e-8)


def test_what_rows_tell_of_columns_sums_to_their_information_less_what_the_shared_unknowns_pay(case):
    basis, made, p, f, c, y = case
    solved = np.linalg.solve(f.T @ p @ f + np.eye(f.shape[1]), f.T @ p @ c)
    told = np.concatenate(basis.beyond(split(made, c)))
    np.testing.assert_allclose(told, (c - f @ solved) * (p @ (c - f @ solved)), atol=1e-8)
    information = np.diagonal(basis.sums(split(made, c), split(made, y)).information)
    np.testing.assert_allclose(told.sum(axis=0) + np.sum(solved**2, axis=0), information, atol=1e-8)


def test_no_columns_at_all(case):
    basis, made, _, f, _, y = case
    sums = basis.sums(split(made, np.zeros((y.size, 0))), split(made, y))
    assert sums.information.shape == (0, 0) and sums.score.shape == (0,) and sums.chi_square > 0.0


def test_otherwise_is_what_a_new_basis_would_be(case):
    _, made, _, f, c, y = case
    parameters, slack = split(made, f[:, :PARAMETERS]), split(made, f[:, PARAMETERS:])
    fresh = Basis(Weighting(made), parameters, [3.0 * s for s in slack], -ENDS, ENDS, 0.2).sums(split(made, c), split(made, y))
    same = Basis(Weighting(made), parameters, slack, -ENDS, ENDS, 0.7).otherwise(0.2, 3.0).sums(split(made, c), split(made, y))
    np.testing.assert_allclose(same.information, fresh.information, atol=1e-9)
    np.testing.assert_allclose(same.score, fresh.score, atol=1e-9)
    assert same.chi_square == pytest.approx(fresh.chi_square, abs=1e-9)


def test_normal_sums_with_bounds_far_away_are_the_plain_ones(case):
    basis, made, _, _, c, y = case
    plain = basis.sums(split(made, c), split(made, y))
    held = basis.normal(split(made, c), split(made, y)).held(np.arange(COLUMNS), np.full(COLUMNS, np.inf), 1.0)
    np.testing.assert_allclose(held.information, plain.information, atol=1e-8)
    np.testing.assert_allclose(held.score, plain.score, atol=1e-8)
    assert held.chi_square == pytest.approx(plain.chi_square, abs=1e-8)


def test_more_slack_is_what_a_new_basis_would_be(case):
    _, made, _, f, c, y = case
    parameters, slack = split(made, f[:, :PARAMETERS]), split(made, f[:, PARAMETERS:])
    fresh = Basis(Weighting(made), parameters, slack, -ENDS, ENDS, 0.7)
    grown = Basis(Weighting(made), parameters, [s[:, :1] for s in slack], -ENDS, ENDS, 0.7).with_more([s[:, 1:] for s in slack])
    assert grown.size == fresh.size
    np.testing.assert_allclose(grown.information, fresh.information, atol=1e-9)
    np.testing.assert_allclose(grown.sums(split(made, c), split(made, y)).information,
                               fresh.sums(split(made, c), split(made, y)).information, atol=1e-9)
    assert grown.misfit(split(made, y)) == pytest.approx(fresh.misfit(split(made, y)), abs=1e-9)


def test_further_unknowns_are_as_if_they_had_been_among_the_parameters(case):
    basis, made, _, f, c, y = case
    first, ends = PARAMETERS - 1, ENDS[:1]
    less = Basis(Weighting(made), split(made, f[:, :first]), split(made, f[:, PARAMETERS:]), -ENDS[:first], ENDS[:first])
    grown = less.with_unknowns(split(made, f[:, first:PARAMETERS]), -ends, ends)
    assert (grown.parameters, grown.size, less.parameters) == (basis.parameters, basis.size, first)
    np.testing.assert_allclose(grown.information, basis.information, atol=1e-9)
    np.testing.assert_array_equal(grown.highest, basis.highest)
    one, other = (b.normal(split(made, c), split(made, y)) for b in (grown, basis))
    np.testing.assert_allclose(one.covariance(1.0), other.covariance(1.0), atol=1e-9)
    assert grown.misfit(split(made, y)) == pytest.approx(basis.misfit(split(made, y)), abs=1e-8)


def test_columns_of_which_the_slack_is_a_share_need_no_products_of_their_own(case):
    _, made, _, f, _, y = case
    parameters, slack, values = split(made, f[:, :PARAMETERS]), split(made, f[:, PARAMETERS:]), split(made, y)
    shares = np.array([0.05, 0.1, 0.1])
    basis = Basis(Weighting(made), parameters, slack, -ENDS, ENDS, 0.7)
    sums, normal = basis.both_of_slack(shares, values)
    columns = [s / shares for s in slack]
    of_both = basis.both(columns, values)
    for name in ("information", "score", "chi_square"):
        np.testing.assert_allclose(getattr(sums, name), getattr(basis.sums(columns, values), name), rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(getattr(of_both[0], name), getattr(basis.sums(columns, values), name))
    for name in ("information", "score", "cross", "own", "own_score", "square"):
        np.testing.assert_allclose(getattr(normal, name), getattr(basis.normal(columns, values), name), rtol=1e-9, atol=1e-9)
        np.testing.assert_array_equal(getattr(of_both[1], name), getattr(basis.normal(columns, values), name))
