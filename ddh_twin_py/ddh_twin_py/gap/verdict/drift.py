"""How far a hypothesis lets the rig drift from what it was when it was commissioned.

What acts only since then leaves the rig as it was. With theta_0, the fit to the commissioning recordings alone, and the cost of
parameters there,

    C(theta) = p r' P r + theta' theta,   Q = C(theta) - C(theta_0),

a right hypothesis about further recordings, fitted to all of them, moves the parameters only as far as the commissioning recordings left
them open. Q is then about chi-squared with n = tr(1 - L S) degrees of freedom, L the information of commissioning and tolerances, S the
covariance with all recordings: as many as the further recordings tell anew. A wrong hypothesis asks for another rig.

Raveri & Hu, Concordance and discordance in cosmology, Phys. Rev. D 99 (2019) 043506, on differences of log-likelihoods at the maxima of
data sets and their effective number of parameters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ddh_twin_py.estimation.fitting.weighting import Weighting
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted

_LEAST = 1.0  # degrees of freedom: where the further recordings tell nothing anew, a drift of one deviation is none


class Drift:
    """Drift from the rig as commissioned.

    Args:
        linearised: the case, with a recording at least in which no effect acts. as_built: parameters fitted to these alone, (k,).

    Attributes:
        expected: n, degrees of freedom. open: covariance that these recordings leave of the parameters, (k, k).
    """

    def __init__(self, linearised: Linearised, as_built: np.ndarray) -> None:
        model, basis, k = linearised.model, linearised.basis, as_built.size
        self._numbers = [number for number, altered in enumerate(model.altered) if not altered]
        self._comparisons = [linearised.comparisons[number] for number in self._numbers]
        self._weighting, self._power = Weighting(self._comparisons), linearised.power
        rows = [linearised.sensitivities[number] for number in self._numbers]
        commissioned = self._power * self._weighting.products(rows, rows) + np.eye(k)
        known = cho_factor(basis.information[:k, :k] + np.eye(k), lower=True, check_finite=False)
        self.open = np.linalg.inv(commissioned)
        self.expected = max(_LEAST, k - float(np.trace(cho_solve(known, commissioned, check_finite=False))))
        self._least = self._cost(as_built, [model.run_one(number, as_built) for number in self._numbers])

    def of(self, fitted: Refitted) -> float:
        """Standard deviations by which Q of a hypothesis is more than is expected of a right one."""
        cost = self._cost(fitted.theta, [fitted.predictions[number] for number in self._numbers])
        return (cost - self._least - self.expected) / math.sqrt(2.0 * self.expected)

    def _cost(self, theta: np.ndarray, predictions: Sequence) -> float:
        residual = [c.residual(p)[:, None] for c, p in zip(self._comparisons, predictions, strict=True)]
        return self._power * float(self._weighting.products(residual, residual)[0, 0]) + float(theta @ theta)
