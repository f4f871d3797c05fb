"""Gaussian unknowns in a linear model: estimates and evidence from sums of the size of the unknowns.

    y = X u + e,  e ~ N(0, P^-1)

Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), section 2.7; Tarantola,
Inverse Problem Theory (2005), chapter 3.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve


def gain(information: np.ndarray, score: np.ndarray, prior: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """What further unknowns add to the log evidence.

    Args:
        information, score: X'PX (k, k) and X'Py (k,), P what is left after the other unknowns. prior: standard deviations, (k,).

    Returns:
        log evidence gained, estimate (k,), covariance (k, k), in the units of the columns.
    """
    scaled = information * np.outer(prior, prior) + np.eye(prior.size)
    factor = cho_factor(scaled, lower=True, check_finite=False)
    estimate = cho_solve(factor, prior * score, check_finite=False)
    log = 0.5 * float(prior * score @ estimate) - float(np.sum(np.log(np.diagonal(factor[0]))))
    covariance = cho_solve(factor, np.eye(prior.size), check_finite=False) * np.outer(prior, prior)
    return log, prior * estimate, covariance
