"""Free runs of held-out data under fits, and how far these and the fitted recordings are off."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.findings import Trace
from ddh_twin_py.gap.model import DescribedModel, Held, Model
from ddh_twin_py.gap.shrink import size

INDEPENDENT = 10.0
"""Independent samples that a signal of held-out data has at least: of its mean square, over floor, so many times half is evidence."""


class HeldRuns:
    """Free runs of held-out data under fits; each fit is run once.

    Args:
        held: the data. floor: of each signal, in multiples of its noise.
    """

    def __init__(self, held: Held, floor: Mapping[str, float]) -> None:
        self.held, self.floor = held, floor
        self._known: dict[int, tuple[Refitted, list[dict[str, np.ndarray]]]] = {}  # the fit is kept, so that its id stays its own

    def of(self, fitted: Refitted) -> list[dict[str, np.ndarray]]:
        """Predictions, by recording."""
        if id(fitted) not in self._known:
            self._known[id(fitted)] = fitted, self.held.run(fitted.theta, fitted.acting)
        return self._known[id(fitted)][1]

    def ratios(self, fitted: Refitted) -> dict[str, float]:
        """RMS over noise of each signal."""
        return ratios_of(self.held, self.of(fitted))

    def over(self, fitted: Refitted) -> dict[str, float]:
        """RMS over floor of each signal."""
        return {name: ratio / self.floor[name] for name, ratio in self.ratios(fitted).items()}

    def gap(self, fitted: Refitted) -> float:
        """Gap that a fit leaves; see `size.gap`."""
        return size.gap(self.ratios(fitted), self.floor)

    def speaks(self, fitted: Refitted, other: Refitted) -> float:
        """Log evidence of held-out data for a fit over another, as run; minus infinity where it goes astray and the other does not."""
        mine, others = self.over(fitted), self.over(other)
        return 0.5 * INDEPENDENT * sum(others[name] ** 2 - mine[name] ** 2 for name in mine)

    def interval(self, name: str, runs: list[dict[str, np.ndarray]]) -> list[float] | None:
        """95 % interval of the RMS that runs leave of a signal, in its unit; None where no sample counts."""
        both = zip(self.held.signals(), runs, strict=True)
        low, high = size.interval([(own[name], run[name]) for own, run in both if name in own], self.held.mask())
        return [low, high] if np.isfinite(low) else None


def ratios_of(held: Held, runs) -> dict[str, float]:
    """RMS over noise of each signal, all held-out recordings together."""
    return size.pooled(list(zip(held.signals(), runs, strict=True)), held.mask())


def first_of_each(held: Held) -> dict[str, object]:
    """Each signal as the first of the held-out recordings that have it reads it."""
    return {name: signal for own in reversed(held.signals()) for name, signal in own.items()}


def traces(held: Held, before: Mapping[str, np.ndarray], after: Mapping[str, np.ndarray], floor: Mapping[str, float]) -> dict[str, Trace]:
    """Signals of the first held-out recording, in order of time, with two runs of it."""
    mask, out = held.mask(), {}
    for name, signal in held.signals()[0].items():
        used = np.flatnonzero(mask(signal))
        if used.size:
            order = used[np.argsort(signal.time[used], kind="stable")]
            out[name] = Trace(signal.time[order], signal.measured[order], before[name][order], after[name][order], signal.unit,
                              signal.noise, floor[name] * signal.noise)
    return out


def in_fitted(model: DescribedModel, fitted: Refitted, floor: Mapping[str, float], acts: bool) -> dict[str, float]:
    """RMS over floor of each signal of the fitted recordings in which effects act, or of the others, beside a fit."""
    return {name: ratio / floor[name] for name, ratio in size.pooled(recorded(model, fitted.predictions, acts)).items() if name in floor}


def recorded(model: Model, predictions: Sequence[Mapping[str, np.ndarray]], acts: bool) -> list[tuple[Mapping, Mapping[str, np.ndarray]]]:
    """Signals of the fitted recordings in which effects act, or of the others, each with what was predicted of it."""
    return [(s, p) for s, p, altered in zip(model.signals, predictions, model.altered, strict=True) if altered is acts]
