"""Gaussian unknowns in a linear model: estimates and evidence from sums of the size of the unknowns.

    y = X u + e,  e ~ N(0, P^-1)

Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), section 2.7; Tarantola,
Inverse Problem Theory (2005), chapter 3.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError
from scipy.linalg.lapack import dpotrf, dpotrs


def factored(matrix: np.ndarray) -> np.ndarray:
    """Lower Cholesky factor of a positive definite matrix, (n, n), with anything above it.

    That of LAPACK itself: for the few dozens of unknowns here SciPy's checks of what is given take longer than the work.

    Raises:
        LinAlgError: it is not positive definite.
    """
    factor, failed = dpotrf(matrix, lower=1, clean=0)
    if failed:
        raise LinAlgError(f"leading minor {failed} is not positive")
    return factor


def solved(factor: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of the equations of a matrix that was `factored`, for right-hand sides (n,) or (n, m)."""
    return dpotrs(factor, right, lower=1)[0] if factor.size and right.size else np.zeros(right.shape)


def gain(information: np.ndarray, score: np.ndarray, prior: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """What further unknowns add to the log evidence.

    Args:
        information, score: X'PX (k, k) and X'Py (k,), P what is left after the other unknowns. prior: standard deviations, (k,).

    Returns:
        log evidence gained, estimate (k,), covariance (k, k), in the units of the columns.
    """
    scaled = information * np.outer(prior, prior) + np.eye(prior.size)
    factor = factored(scaled)
    estimate = solved(factor, prior * score)
    log = 0.5 * float(prior * score @ estimate) - float(np.sum(np.log(np.diagonal(factor))))
    covariance = solved(factor, np.eye(prior.size)) * np.outer(prior, prior)
    return log, prior * estimate, covariance
