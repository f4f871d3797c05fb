"""Weights with the model's allowances integrated out, against the dense formula and against the sums of a fit."""

import numpy as np
import pytest
from ddh_twin_py.estimation.allowances import sums_of
from ddh_twin_py.estimation.weighting import Weighting
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


def test_products_are_the_sums_of_a_fit(made, dense):
    rng = np.random.default_rng(2)
    columns, values = rng.normal(size=(dense.shape[0], 4)), rng.normal(size=dense.shape[0])
    gram, log_determinant = sums_of(made, split(made, columns), split(made, values)).gram()
    weighting = Weighting(made)
    np.testing.assert_allclose(gram.xx, weighting.products(split(made, columns), split(made, columns)), atol=1e-9)
    np.testing.assert_allclose(gram.xy, weighting.products(split(made, columns), split(made, values[:, None]))[:, 0], atol=1e-9)
    assert gram.yy == pytest.approx(values @ np.linalg.solve(dense, values), abs=1e-9)
    assert log_determinant == pytest.approx(weighting.log_determinant, abs=1e-9)


def test_a_flaw_that_recordings_share_counts_once(made):
    """Values that lie along a shared class weigh less than what the recordings, each by itself, make of them."""
    names = [made[0].blocks[0].names[0]]
    rows = [np.concatenate([np.where(np.array([b.names[k] in names for k in b.kind]), b.load, 0.0) if b.names else np.zeros(b.spread.size)
                            for b in c.blocks])[:, None] for c in made]
    together = Weighting(made).products(rows, rows)[0, 0]
    alone = sum(Weighting([c]).products([r], [r])[0, 0] for c, r in zip(made, rows, strict=True))
    assert 0.0 < together < alone
