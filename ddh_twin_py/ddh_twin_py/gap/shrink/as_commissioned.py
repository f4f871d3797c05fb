"""Whether later recordings are what the rig would show as it was commissioned, no effect acting.

A commissioning recording leaves parameters open by a covariance C about its fit. Runs with parameters, and begins, drawn from it say how
far each signal may be from the run at that fit, o; the floor says how far a measurement may be from its run. Held against both, in mean
squares over a signal's samples,

    surprise = o_measured^2 / (1 + E o_drawn^2),   o in floors

is about one or less where nothing has changed since, and grows with the square of what has; where a drawn run goes astray, it is none.
Parameters that are fitted to the later recordings, too, would take a change up as far as they were left open. What has changed shows in
field and held-out data alike, what is uncertain of one recording's begin in that one alone: so the mean of both is taken.

Box, Sampling and Bayes' inference in scientific modelling and robustness, J. R. Stat. Soc. A 143 (1980) 383, on prior predictive checks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.gap.model import Held, Model
from ddh_twin_py.gap.shrink.size import counted

SURPRISED, _SURPRISED_SOFTNESS = 3.0, 0.15
"""Mean square by which a signal may be off beside the rig as commissioned, over what is expected (`Surprise.ratio`), until
something is as likely to act as nothing."""
SURPRISED_ALONE = 6.0
"""The same where held-out data are the end of the field recording itself: what is open of the rig may shift a signal throughout one
recording as one number, of which the square is three times what is expected in one of twelve."""
_SELDOM = 6.6
"""Square, over what is expected of it, that such a number exceeds in one of a hundred; field and held-out data may share the number."""
UNSURPRISING = SURPRISED - 4.0 * _SURPRISED_SOFTNESS
"""The same below which a signal need not be asked about."""
_DRAWS = 40
_POSITIVE = 1e-9  # added to what is open, as a fit may know a parameter all but exactly

_Run = Callable[[np.ndarray, np.ndarray], list[Mapping[str, np.ndarray]]]
_Squares = dict[str, float]


@dataclass(frozen=True)
class Surprise:
    """A signal beside the rig as commissioned.

    Attributes:
        signal: name. ratio: of the squares of the next two, a mean over field and held-out data.
        off, expected: RMS over floor in the data that it was most surprising in: how far it is off, and how far it may be.
    """

    signal: str
    ratio: float
    off: float
    expected: float

    def limit(self, alone: bool) -> float:
        """Ratio at which something is as likely to act as nothing; ``alone``: of the field recordings alone."""
        of_the_rig = max(self.expected, 1.0) ** 2 - 1.0
        return max(SURPRISED_ALONE if alone else SURPRISED, (1.0 + _SELDOM * of_the_rig) / (1.0 + of_the_rig))


@dataclass(frozen=True)
class _Data:
    """Recordings of one kind: what was measured, which samples count, and how to run them at parameters (k,) and begins (b,)."""

    signals: Sequence[Mapping]
    mask: Callable
    begins: int
    run: _Run

    def squares(self, values: Sequence[Mapping], runs: Sequence[Mapping], floor: Mapping[str, float]) -> _Squares:
        """Mean square over floor by which values are off runs, by signal, over all recordings; what went astray is infinitely off."""
        found: dict[str, list[float]] = {}
        for signals, own, run in zip(self.signals, values, runs, strict=True):
            for name, signal in signals.items():
                used = self.mask(signal) & np.isfinite(signal.measured)
                if used.any() and name in floor:
                    square = float(np.mean(((own[name] - run[name])[used] / (signal.noise * floor[name])) ** 2))
                    found.setdefault(name, []).append(square if np.isfinite(square) else np.inf)
        return {name: float(np.mean(squares)) for name, squares in found.items()}

    def measured(self) -> list[dict[str, np.ndarray]]:
        return [{name: signal.measured for name, signal in own.items()} for own in self.signals]


def surprises(model: Model, held: Held | None, floor: Mapping[str, float], theta: np.ndarray, covariance: np.ndarray,
              least: float) -> list[Surprise]:
    """Signals that are off beside the rig as commissioned, the most surprising first.

    Args:
        model: of the case. held: data of another duty; None where held-out data are the end of the field recordings, of which the
            fitted part is asked.
        floor: of each signal, in multiples of its noise.
        theta: parameters fitted to commissioning alone, in deviations, (k,). covariance: what it left open of them, (k, k).
        least: mean square over floor from which a signal is asked about; what is off by less surprises nobody.
    """
    kinds = [_field(model), *([_held(held)] if held is not None else [])]
    root = np.linalg.cholesky(covariance + _POSITIVE * np.eye(theta.size))
    rng = np.random.default_rng(0)
    found: dict[str, list[tuple[float, float, float]]] = {}
    plain = [data.run(theta, np.zeros(data.begins)) for data in kinds]
    off = [data.squares(data.measured(), run, floor) for data, run in zip(kinds, plain, strict=True)]
    asked = {name for own in off for name, square in own.items() if square > least}
    if not asked:
        return []
    for data, run, own in zip(kinds, plain, off, strict=True):
        moves = rng.standard_normal((_DRAWS, theta.size)) @ root.T, rng.standard_normal((_DRAWS, data.begins))

        def moved(move: tuple[np.ndarray, np.ndarray], data=data, run=run) -> _Squares:
            return data.squares(data.run(model.within(theta + move[0]), move[1]), run, floor)

        with ThreadPoolExecutor(max_workers=THREADS) as pool:
            drawn = list(pool.map(moved, zip(*moves, strict=True)))
        for name in asked & set(own):
            expected = 1.0 + float(np.mean([one[name] for one in drawn]))
            found.setdefault(name, []).append((own[name] / expected if np.isfinite(expected) else 0.0, own[name], expected))
    out = [Surprise(name, float(np.mean([r for r, _, _ in several])), *(float(np.sqrt(v)) for v in max(several)[1:]))
           for name, several in found.items()]
    return sorted(out, key=lambda one: -one.ratio)


def something_acts(surprises: Sequence[Surprise], alone: bool = False) -> tuple[float, str]:
    """How probable it is that something acts, as the rig as commissioned would not show what was recorded since; and a note that says so.

    Args:
        surprises: of the signals that a run follows, the largest first. alone: whether they are of the field recordings alone.
    """
    if not surprises:
        return 0.0, ""
    worst = max(surprises, key=lambda one: one.ratio - one.limit(alone))
    note = (f"without any effect the rig as commissioned would not show this: {worst.signal} is {worst.off:.1f} times its floor off, and "
            f"what the commissioning recording left open of the rig makes it {worst.expected:.1f}")
    return float(expit((worst.ratio - worst.limit(alone)) / _SURPRISED_SOFTNESS)), note


def _field(model: Model) -> _Data:
    """Recordings in which effects may act; their begins are among the parameters."""
    numbers = [number for number, acts in enumerate(model.altered) if acts]
    return _Data([model.signals[n] for n in numbers], counted, 0, lambda theta, _: [model.run_one(n, theta, ()) for n in numbers])


def _held(held: Held) -> _Data:
    ways = held.open_begins()
    ends = np.cumsum(ways)
    return _Data(held.signals(), held.mask(), int(ends[-1]), lambda theta, z: held.run(theta, (), np.split(z, ends[:-1])))
