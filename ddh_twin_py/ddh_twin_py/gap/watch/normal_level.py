"""What a stretch of reference data shows as normal: level, floor and spread of each signal's residual.

Bin means of a residual are correlated: the duty repeats, temperatures move slowly. They are taken as
x(t) = phi·x(t-1) + e(t), and what of the correlation such a process does not hold is added to the
spread of e, from the means of ever longer batches of e.

Box, Jenkins, Reinsel, Time Series Analysis (2008), chapter 3, for the process; Kendall, Biometrika 41 (1954),
for the bias of its coefficient; Alexopoulos, Seila, Handbook of Simulation (1998), chapter 7, for batch means.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.rig.files import read_json, write_whole

LEAST_BINS = 20
"""Bins below which nothing can be said of a signal's spread."""
_LEAST_PHASE = 5  # bins in which a phase must have been seen
_LEAST_BATCHES = 8
_MOST_CORRELATED = 0.99
_VERSION = 1


class NormalLevelError(ValueError):
    """A file of normal levels cannot be used; one line for people."""


@dataclass(frozen=True)
class NormalLevel:
    """The residual of one signal while nothing is wrong, in the signal's unit.

    Attributes:
        level: mean in each phase, NaN for a phase that was not seen.
        floor: noise of one sample together with what the model leaves.
        spread: standard deviation of e, one bin's own part of the bin mean. correlation: phi of neighbouring bin means, 0 to 0.99.
        bins: how many it was learned from. samples: in a usual bin.
    """

    level: tuple[float, ...]
    floor: float
    spread: float
    correlation: float
    bins: int
    samples: float


@dataclass(frozen=True)
class Bins:
    """Sums of one signal's residual over n bins and P phases.

    Attributes:
        index: number of each bin in time, increasing, (n,). total, square: sums of the residual and of its square, (n, P).
        count: samples, (n, P).
    """

    index: np.ndarray
    total: np.ndarray
    square: np.ndarray
    count: np.ndarray

    def means(self, level: np.ndarray) -> np.ndarray:
        """Mean of each bin about the level of its phases, NaN where no phase is known; (n,)."""
        known = np.isfinite(level)
        count = self.count[:, known].sum(axis=1)
        rest = (self.total[:, known] - level[known] * self.count[:, known]).sum(axis=1)
        return np.divide(rest, count, out=np.full(count.size, np.nan), where=count > 0)


def normal_level(bins: Bins, noise: float, floor_with_level: bool = False) -> NormalLevel | None:
    """Learn the normal level from reference bins.

    Args:
        noise: of one sample, NaN where it is not known. floor_with_level: count the level itself among what the model leaves;
            for signals whose level comes and goes with the duty's length, as a temperature's does.

    Returns:
        None where there are fewer than `LEAST_BINS` bins, or a residual that does not move at all.
    """
    seen = (bins.count > 0).sum(axis=0) >= min(_LEAST_PHASE, bins.index.size)
    count = bins.count.sum(axis=0)
    level = np.divide(bins.total.sum(axis=0), count, out=np.full(count.size, np.nan), where=seen & (count > 0))
    x = bins.means(level)
    used = np.isfinite(x)
    x, index = x[used], bins.index[used]
    if x.size < LEAST_BINS:
        return None
    known = np.isfinite(level)
    about = np.zeros(known.sum()) if floor_with_level else level[known]
    square = bins.square[:, known] - 2.0 * about * bins.total[:, known] + about**2 * bins.count[:, known]
    left = math.sqrt(max(0.0, float(square.sum() / bins.count[:, known].sum())))
    correlation = _correlation(x, index)
    own = whitened(x, index, correlation)
    variance = float(own @ own) / (x.size - 1)
    spread = math.sqrt(max(variance, _batch_variance(own)))
    floor = math.hypot(noise if math.isfinite(noise) else 0.0, left)
    if not spread > 0.0 or not floor > 0.0:
        return None
    return NormalLevel(tuple(level.tolist()), floor, spread, correlation, int(x.size), float(count.sum() / bins.index.size))


def _correlation(x: np.ndarray, index: np.ndarray) -> float:
    """phi from neighbouring bins, its bias of -(1 + 3·phi)/n taken off and one standard error added: too little would be too sure."""
    follow = np.diff(index) == 1
    pairs = int(follow.sum())
    if pairs < LEAST_BINS // 2:
        return 0.0
    first, second = x[:-1][follow], x[1:][follow]
    power = math.sqrt(float(first @ first) * float(second @ second))
    phi = float(first @ second) / power if power > 0.0 else 0.0
    phi += (1.0 + 3.0 * phi) / pairs
    return min(max(phi + math.sqrt(max(0.0, 1.0 - phi**2) / pairs), 0.0), _MOST_CORRELATED)


def whitened(x: np.ndarray, index: np.ndarray, correlation: float) -> np.ndarray:
    """e of each bin mean, all with one standard deviation also where bins are missing between; (n,)."""
    passed = correlation ** np.diff(index)
    own = x.copy()
    own[1:] -= passed * x[:-1]
    own[0] *= math.sqrt(1.0 - correlation**2)
    own[1:] *= np.sqrt((1.0 - correlation**2) / (1.0 - passed**2))
    return own


def _batch_variance(own: np.ndarray) -> float:
    """Largest of length times variance of batch means, over batches of 2, 4, 8 ... bins, each with two standard errors added."""
    largest, length = 0.0, 2
    while own.size // length >= _LEAST_BATCHES:
        batches = own.size // length
        means = own[: batches * length].reshape(batches, length).mean(axis=1)
        largest = max(largest, length * float(means @ means) / (batches - 1) * (1.0 + 2.0 * math.sqrt(2.0 / (batches - 1))))
        length *= 2
    return largest


def save_levels(path: str | Path, rig_id: str, bin_length: float, levels: Mapping[str, NormalLevel]) -> None:
    """Write normal levels as JSON, whole or not at all; bin_length in s. Raises OSError."""
    content = {
        "version": _VERSION, "rig_id": rig_id, "bin": bin_length,
        "signals": {name: {**asdict(level), "level": [v if math.isfinite(v) else None for v in level.level]}
                    for name, level in levels.items()},
    }  # fmt: skip
    write_whole(path, json.dumps(content, indent=1, allow_nan=False) + "\n")


def load_levels(path: str | Path, bin_length: float, phases: Mapping[str, int] | None = None) -> tuple[str, dict[str, NormalLevel]]:
    """Rig id and normal levels by signal.

    Args:
        bin_length: s. phases: how many each signal's level must have; any, where a signal is not named.

    Raises:
        NormalLevelError: the file cannot be read, is none of ours, or was learned with bins of another length or other phases.
    """
    try:
        content = read_json(path)
    except OSError as error:
        raise NormalLevelError(f"{path}: {error.strerror or error}") from None
    except ValueError as error:
        raise NormalLevelError(f"{path}: is no JSON ({error})") from None
    try:
        if content["version"] != _VERSION:
            raise NormalLevelError(f"{path}: version is {content['version']!r}, it must be {_VERSION}")
        if content["bin"] != bin_length:
            raise NormalLevelError(f"{path}: bin is {content['bin']!r} s, the test's bins are {bin_length:g} s")
        levels = {name: _level(path, name, row, (phases or {}).get(name)) for name, row in content["signals"].items()}
        if not isinstance(content["rig_id"], str):
            raise NormalLevelError(f"{path}: rig_id is {content['rig_id']!r}, a string is needed")
        return content["rig_id"], levels
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        if isinstance(error, NormalLevelError):
            raise
        raise NormalLevelError(f"{path}: is no file of normal levels ({type(error).__name__}: {error})") from None


def _level(path: str | Path, name: str, row: Mapping, phases: int | None) -> NormalLevel:
    level = tuple(math.nan if v is None else float(v) for v in row["level"])
    made = NormalLevel(level, *(float(row[k]) for k in ("floor", "spread", "correlation")), int(row["bins"]), float(row["samples"]))
    allowed = {"floor": made.floor > 0.0, "spread": made.spread > 0.0, "bins": made.bins >= LEAST_BINS, "samples": made.samples > 0.0,
               "correlation": 0.0 <= made.correlation <= _MOST_CORRELATED}  # fmt: skip
    if phases not in (None, len(level)):
        raise NormalLevelError(f"{path}: signals.{name}.level: found {len(level)} of the {phases} needed, one for each phase")
    if not np.isfinite(level).any():
        raise NormalLevelError(f"{path}: signals.{name}.level: value is {row['level']!r}, which no normal level has")
    for key, well in allowed.items():
        if not well or not math.isfinite(getattr(made, key)):
            raise NormalLevelError(f"{path}: signals.{name}.{key}: value is {row[key]!r}, which no normal level has")
    return made
