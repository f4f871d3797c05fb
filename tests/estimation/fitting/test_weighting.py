"""Weights with the model's allowances integrated out, against the dense formula and against the sums of a fit."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.weighting import Weighting
from support.made_comparison import comparisons, dense_allowances, split


@pytest.fixture(scope="module")
def made():
    return comparisons()


@pytest.fixture(scope="module")
def dense(made):
    a = dense_allowances(made)
    return np.eye(a.shape[0]) + a @ a.T


def test_applied_is_the_inverse_of_the_dense_covariance(made, dense):
    columns = np.random.default_rng(1).normal(size=(dense.shape[0], 3))
    weighting = Weighting(made)
    found = np.vstack(weighting.applied(split(made, columns)))
    assert weighting.rows == dense.shape[0]
    np.testing.assert_allclose(found, np.linalg.solve(dense, columns), atol=1e-10)
    assert np.abs(found - columns).max() > 0.1


def test_log_determinant(made, dense):
    assert Weighting(made).log_determinant == pytest.approx(np.linalg.slogdet(dense)[1], abs=1e-9)


def test_products_are_those_of_dense_algebra(made, dense):
    rng = np.random.default_rng(2)
    left, right = rng.normal(size=(dense.shape[0], 4)), rng.normal(size=(dense.shape[0], 2))
    products = Weighting(made).products(split(made, left), split(made, right))
    np.testing.assert_allclose(products, left.T @ np.linalg.solve(dense, right), atol=1e-9)


def test_classes_are_what_is_expected_of_them_given_the_residuals(made, dense):
    """Mean and variance of each class in units of its allowance: a' S^-1 r and 1 - a' S^-1 a with a the class's loads."""
    residuals = np.random.default_rng(3).normal(size=dense.shape[0])
    found = Weighting(made).classes(split(made, residuals))
    assert len(found) > 4
    for name, (mean, variance) in found.items():
        loads = np.concatenate([np.concatenate([np.where([b.names[k] == name for k in b.kind], b.load, 0.0) if b.names
                                                else np.zeros(b.spread.size) for b in c.blocks]) for c in made])
        assert mean == pytest.approx(loads @ np.linalg.solve(dense, residuals), abs=1e-9)
        assert variance == pytest.approx(1.0 - loads @ np.linalg.solve(dense, loads), abs=1e-9)


def test_a_flaw_that_recordings_share_counts_once(made):
    """Values that lie along a shared class weigh less than what the recordings, each by itself, make of them."""
    names = [made[0].blocks[0].names[0]]
    rows = [np.concatenate([np.where(np.array([b.names[k] in names for k in b.kind]), b.load, 0.0) if b.names else np.zeros(b.spread.size)
                            for b in c.blocks])[:, None] for c in made]
    together = Weighting(made).products(rows, rows)[0, 0]
    alone = sum(Weighting([c]).products([r], [r])[0, 0] for c, r in zip(made, rows, strict=True))
    assert 0.0 < together < alone
