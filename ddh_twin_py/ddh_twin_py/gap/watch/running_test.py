"""Has a gap opened: a two-sided CUSUM on bin means of each signal's residual, with a declared rate of false alarms.

A residual's samples are averaged over bins of stamp time, the normal level of each phase is taken off
(`normal_level`), and what is left is freed from the correlation of its neighbours. With e of standard deviation 1

    up(t) = max(0, up(t-1) + e(t) - k),  down(t) = max(0, down(t-1) - e(t) - k),

and a gap has opened once either is above the threshold h. k lies half way to the smallest gap that matters,
and further by twice the standard error of the learned level. h follows from the mean time between
false alarms by Siegmund's approximation; every signal has its equal part of that rate.

Page, Biometrika 41 (1954); Siegmund, Sequential Analysis (1985), section II.6;
Lu, Reynolds, Journal of Quality Technology 33 (2001), for residuals of correlated data.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.gap.shrink.size import WITHOUT_COMMISSIONING
from ddh_twin_py.gap.watch.normal_level import LEAST_BINS, Bins, NormalLevel, normal_level

_OVERSHOOT = 1.166  # of a random walk over a boundary, twice Siegmund's 0.583
_LEVEL_ERROR = 2.0  # standard errors of the learned level that are allowed for
_FARTHEST = 4.0  # beyond k, standard deviations that one bin may count: one odd bin alone opens no gap
_LEAST_THRESHOLD = 6.0  # so that it takes two bins at least
_LEAST_FILLED = 0.5  # of the usual samples, below which a bin is left out
_SILENT = 3  # bins of working time with too few samples, after which a signal counts as not heard
_MEMORY = 60  # bins over which an open gap's size is averaged


def run_length(k: float, h: float) -> float:
    """Mean number of steps until a one-sided CUSUM of standard normal steps with allowance k passes h; Siegmund's approximation."""
    b = h + _OVERSHOOT
    if k * b < 1e-4:
        return b * b
    exponent = 2.0 * k * b
    return math.inf if exponent > 600.0 else (math.expm1(exponent) - exponent) / (2.0 * k * k)


def threshold(k: float, steps: float) -> float:
    """h of a two-sided CUSUM whose mean number of steps between false alarms is `steps`."""
    low, high = 0.0, math.sqrt(2.0 * steps) + 1.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if run_length(k, middle) < 2.0 * steps else (low, middle)
    return max(high, _LEAST_THRESHOLD)


@dataclass(frozen=True)
class Settings:
    """Of running tests on one clock.

    Attributes:
        bin_length: s. learning: s of working time from which each signal's normal level is learned.
        between_alarms: s of working time, mean between false alarms of all signals together.
        smallest: gap that the tests are made to find, in multiples of the floor.
    """

    bin_length: float = 20.0
    learning: float = 3600.0
    between_alarms: float = 1000.0 * 3600.0
    smallest: float = 0.5


@dataclass(frozen=True)
class SignalStatus:
    """How the test of one signal stands; sizes in the signal's unit.

    Attributes:
        learned: share of the normal level, 1 once the signal is tested. floor: NaN while not known.
        statistic: the larger of both sides. threshold: NaN while learning.
        opened: a gap is open. since: s of stamp time at which it seems to have begun, NaN where none is open.
        size, size_deviation: mean departure since then and its standard deviation. detectable: the smallest size the test is made for.
        unheard: s of working time for which too few samples came to be tested, 0 below `_SILENT` bins.
    """

    signal: str
    learned: float
    floor: float
    statistic: float = 0.0
    threshold: float = math.nan
    opened: bool = False
    since: float = math.nan
    size: float = math.nan
    size_deviation: float = math.nan
    detectable: float = math.nan
    unheard: float = 0.0

    @property
    def tested(self) -> bool:
        """Whether its normal level is known and it is heard."""
        return math.isfinite(self.threshold) and self.unheard == 0.0


class _Side:
    """One side of the CUSUM, with the mean of the bins since it last was at zero."""

    def __init__(self) -> None:
        self.value = 0.0
        self.first = 0  # bin
        self.bins = 0
        self.mean = 0.0

    def step(self, gain: float, most: float, x: float, index: int) -> None:
        if self.value <= 0.0:
            self.first, self.bins, self.mean = index, 0, 0.0
        self.bins += 1
        self.mean += (x - self.mean) / min(self.bins, _MEMORY)
        self.value = min(max(0.0, self.value + gain), most)


class SignalTest:
    """The running test of one signal whose normal level is known."""

    def __init__(self, level: NormalLevel, smallest: float, steps: float) -> None:
        self.level = level
        self.detectable = smallest * level.floor
        inflated = level.spread * (1.0 + 1.0 / math.sqrt(2.0 * level.bins))  # the spread is known from so many bins
        self.scale = inflated
        aimed = 0.5 * self.detectable * (1.0 - level.correlation) / inflated
        self.k = aimed + _LEVEL_ERROR / math.sqrt(level.bins)
        self.threshold = threshold(aimed, steps)
        self.reset()

    def reset(self) -> None:
        """Forget everything but the normal level."""
        self._up, self._down = _Side(), _Side()
        self._last: tuple[int, float] | None = None
        self._open: _Side | None = None

    def step(self, index: int, x: float) -> None:
        """One bin: its number in time and its mean about the normal level."""
        phi = self.level.correlation
        passed = phi ** (index - self._last[0]) if self._last is not None else 0.0
        before = self._last[1] if self._last is not None else 0.0
        e = (x - passed * before) * math.sqrt((1.0 - phi**2) / (1.0 - passed**2)) / self.scale
        e = min(max(e, -self.k - _FARTHEST), self.k + _FARTHEST)
        self._last = index, x
        self._up.step(e - self.k, self.threshold + _FARTHEST, x, index)
        self._down.step(-e - self.k, self.threshold + _FARTHEST, x, index)
        if self._open is not None and self._open.value <= 0.0:
            self._open = None
        side = max(self._up, self._down, key=lambda s: s.value)
        if side.value > self.threshold:
            self._open = side

    def status(self, signal: str, bin_length: float) -> SignalStatus:
        """Where the test stands; bin_length in s."""
        value, opened = max(self._up.value, self._down.value), self._open
        level = self.level
        same = {"learned": 1.0, "floor": level.floor, "statistic": value, "threshold": self.threshold, "detectable": self.detectable}
        if opened is None:
            return SignalStatus(signal, **same)
        return SignalStatus(signal, **same, opened=True, since=opened.first * bin_length, size=opened.mean,
                            size_deviation=self._mean_deviation(min(opened.bins, _MEMORY)))  # fmt: skip

    def _mean_deviation(self, n: int) -> float:
        """Standard deviation of the mean of n neighbouring bins, that of the learned level included."""
        phi = self.level.correlation
        own = (n * (1.0 + phi) / (1.0 - phi) - 2.0 * phi * (1.0 - phi**n) / (1.0 - phi) ** 2) / (n * n) / (1.0 - phi**2)
        return self.level.spread * math.sqrt(own + 1.0 / ((1.0 - phi) ** 2 * self.level.bins))


class RunningTest:
    """Running tests of several signals on one clock.

    Args:
        signals: names. noise: of one sample of each, in its unit, NaN where not known. phases: how many there are.
        settings: with other running tests on the clock, there are `among` signals that share the false alarms; None where these are all.
        floor_with_level: see `normal_level`. known: normal levels that need not be learned.
    """

    def __init__(self, signals: Sequence[str], noise: Sequence[float], phases: int, settings: Settings, among: int | None = None,
                 floor_with_level: bool = False, known: Mapping[str, NormalLevel] | None = None) -> None:
        self.signals, self.noise, self.phases = tuple(signals), np.asarray(noise, float), phases
        self.bin_length = settings.bin_length
        self._bin_ns = round(self.bin_length * 1e9)
        self._wanted = max(LEAST_BINS, round(settings.learning / self.bin_length))
        self._steps = settings.between_alarms / self.bin_length * (among or len(signals))
        self._smallest, self._floor_with_level = settings.smallest, floor_with_level
        self.resets = 0
        self._silent = np.zeros(len(self.signals), dtype=int)  # bins of working time without enough samples, by signal
        self._tests = {name: self._test(known[name]) for name in signals if known and name in known}
        self._learned: dict[str, list[tuple]] = {name: [] for name in self.signals if name not in self._tests}
        self._clear()

    def _test(self, level: NormalLevel) -> SignalTest:
        return SignalTest(level, self._smallest, self._steps)

    def _clear(self) -> None:
        shape = len(self.signals), self.phases
        self._index: int | None = None
        self._newest: int | None = None
        self._newest_end = 0
        self._worked = False
        self._total, self._square, self._count = np.zeros(shape), np.zeros(shape), np.zeros(shape)

    def reset(self) -> None:
        """The clock jumped: statistics and what was learned so far begin anew, levels that are complete stay."""
        self.resets += 1
        for test in self._tests.values():
            test.reset()
        for bins in self._learned.values():
            bins.clear()
        self._silent[:] = 0
        self._clear()

    def bins(self, stamp_ns: np.ndarray) -> np.ndarray:
        """Number of the bin of each stamp, which is the end of what it stands for; int64 (n,)."""
        return (stamp_ns - 1) // self._bin_ns

    def worked_at(self, stamp_ns: np.ndarray) -> None:
        """The machine moved at these stamps, int64 (n,), without a sample or after it: the bin in hand counts if one is in it."""
        self._worked |= bool((self.bins(stamp_ns) == self._index).any())

    def advance(self, stamp_ns: np.ndarray, residual: np.ndarray, phase: np.ndarray, works: np.ndarray) -> int:
        """Take in n samples; how many bins were finished.

        Args:
            stamp_ns: int64 (n,), increasing; where it steps back the test is reset. residual: measured minus
                predicted, (n, S), NaN where there is none. phase: number of each sample's phase, (n,).
            works: the machine moves, (n,); bins in which it never does are left out.
        """
        n = stamp_ns.size
        before = np.concatenate(([self._newest if self._newest is not None else stamp_ns[0]], stamp_ns[:-1])) if n else stamp_ns
        number = self.bins(stamp_ns)
        cuts = np.flatnonzero((np.diff(number, prepend=number[:1]) != 0) | (stamp_ns < before))
        finished = 0
        edges = sorted({0, n, *cuts.tolist()})
        for start, stop in zip(edges[:-1], edges[1:], strict=True):
            if self._newest is not None and stamp_ns[start] < self._newest:
                self.reset()
            if self._index is not None and number[start] != self._index:
                finished += self._finish()
            self._index, self._newest = int(number[start]), int(stamp_ns[stop - 1])
            self._add(residual[start:stop], phase[start:stop])
            self._worked |= bool(works[start:stop].any())
        return finished

    def _add(self, residual: np.ndarray, phase: np.ndarray) -> None:
        for p in np.unique(phase):
            rows = residual[phase == p]
            there = np.isfinite(rows)
            rows = np.where(there, rows, 0.0)
            self._total[:, p] += rows.sum(axis=0)
            self._square[:, p] += (rows**2).sum(axis=0)
            self._count[:, p] += there.sum(axis=0)

    def _finish(self) -> int:
        if self._worked:
            for s, name in enumerate(self.signals):
                heard = self._count[s].any() and self._take_bin(s, name)
                self._silent[s] = 0 if heard else self._silent[s] + 1
        self._total[:], self._square[:], self._count[:], self._worked = 0.0, 0.0, 0.0, False
        self._newest_end = (self._index + 1) * self._bin_ns
        return 1

    def _take_bin(self, s: int, name: str) -> bool:
        """Test a bin, or learn from it; whether it has enough samples for that."""
        total, square, count = self._total[s].copy(), self._square[s].copy(), self._count[s].copy()
        test = self._tests.get(name)
        if test is not None:
            level = np.array(test.level.level)
            x = Bins(np.zeros(1), total[None], square[None], count[None]).means(level)[0]
            enough = math.isfinite(x) and count[np.isfinite(level)].sum() >= _LEAST_FILLED * test.level.samples
            if enough:
                test.step(self._index, float(x))
            return bool(enough)
        learned = self._learned[name]
        learned.append((self._index, total, square, count))
        if len(learned) >= self._wanted and not self._learn(s, name):
            learned.pop(0)
        return True

    def _learn(self, s: int, name: str) -> bool:
        """Take the bins so far as normal; whether they told enough."""
        bins = Bins(*(np.array(column) for column in zip(*self._learned[name], strict=True)))
        level = normal_level(bins, float(self.noise[s]), self._floor_with_level)
        if level is None:
            return False
        self._tests[name] = self._test(level)
        del self._learned[name]
        return True

    def end_learning(self) -> None:
        """Take what was learned so far as normal, for each signal that has `LEAST_BINS` bins: a reference recording has ended."""
        for s, name in enumerate(self.signals):
            if len(self._learned.get(name, ())) >= LEAST_BINS:
                self._learn(s, name)

    @property
    def levels(self) -> dict[str, NormalLevel]:
        """Normal levels that are complete, by signal."""
        return {name: test.level for name, test in self._tests.items()}

    @property
    def newest_ns(self) -> int | None:
        """Stamp of the newest sample, ns; None before the first."""
        return self._newest

    @property
    def newest_end_ns(self) -> int:
        """Stamp at which the newest finished bin ended, ns; 0 before the first, and after a clock jump."""
        return self._newest_end

    def expected(self, phase: np.ndarray) -> np.ndarray:
        """Normal level of each signal in the phase of each sample, 0 where it is not known; (n, S)."""
        table = np.zeros((self.phases, len(self.signals)))
        for s, name in enumerate(self.signals):
            if name in self._tests:
                table[:, s] = np.nan_to_num(self._tests[name].level.level)
        return table[phase]

    def floors(self) -> np.ndarray:
        """Noise floor of each signal, from the noise alone while it is learned; (S,)."""
        return np.array([self._tests[name].level.floor if name in self._tests else WITHOUT_COMMISSIONING * noise
                         for name, noise in zip(self.signals, self.noise.tolist(), strict=True)])  # fmt: skip

    def status(self) -> list[SignalStatus]:
        """How each signal stands, in order."""
        floors = self.floors()
        plain = [
            self._tests[name].status(name, self.bin_length) if name in self._tests
            else SignalStatus(name, min(len(self._learned[name]) / self._wanted, 1.0), float(floors[s]))
            for s, name in enumerate(self.signals)
        ]  # fmt: skip
        unheard = [bins * self.bin_length if bins >= _SILENT else 0.0 for bins in self._silent.tolist()]
        return [replace(status, unheard=seconds) for status, seconds in zip(plain, unheard, strict=True)]
