"""95 % intervals of shares and of medians."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_Z = 1.959963984540054
_DRAWS = 2000


@dataclass(frozen=True)
class Estimate:
    """A number with its 95 % interval and the number of cases it rests on; NaN where there is none."""

    value: float
    low: float
    high: float
    n: int

    def as_json(self) -> dict:
        """Plain numbers, null for NaN."""
        return {k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in vars(self).items()}


def share(hits: Sequence[bool]) -> Estimate:
    """Share of hits with Wilson's interval (J. Am. Stat. Assoc. 22 (1927) 209)."""
    n, k = len(hits), sum(map(bool, hits))
    if n == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    p, z2 = k / n, _Z * _Z
    middle = (p + z2 / (2 * n)) / (1 + z2 / n)
    half = _Z / (1 + z2 / n) * math.sqrt(p * (1 - p) / n + z2 / (4 * n * n))
    low, high = (0.0 if k == 0 else middle - half), (1.0 if k == n else middle + half)
    return Estimate(p, low, high, n)


def median(values: Sequence[float]) -> Estimate:
    """Median with a bootstrap interval, drawn with a fixed seed."""
    return _bootstrap(values, np.median)


def mean(values: Sequence[float]) -> Estimate:
    """Mean with a bootstrap interval, drawn with a fixed seed."""
    return _bootstrap(values, np.mean)


def _bootstrap(values: Sequence[float], statistic) -> Estimate:
    x = np.array([v for v in values if v is not None and math.isfinite(v)])
    if x.size == 0:
        return Estimate(math.nan, math.nan, math.nan, 0)
    drawn = statistic(x[np.random.default_rng(0).integers(0, x.size, (_DRAWS, x.size))], axis=1)
    low, high = np.quantile(drawn, (0.025, 0.975))
    return Estimate(float(statistic(x)), float(low), float(high), int(x.size))
