"""What a free run leaves unexplained, as numbers of known noise and known allowance for the model's own flaws.

Each bin of each signal gives one number, the mean residual over its standard deviation. No model
of a rig fits to its sensors' noise, so every class of bins may be off together by a little (the
discrepancy), and temperatures by a smooth curve. These allowances are random effects: they are
estimated with everything else, and what they can explain counts for nothing.

Kennedy & O'Hagan, Bayesian calibration of computer models, J. R. Statist. Soc. B 63 (2001) 425.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ddh_twin_py.estimation.fitting.binning import TRANSIENT, Binning
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

CLOCK_JITTER = 1.0e-3
"""s, standard deviation of a stamp; a steep signal is less certain by it."""
_START_DECAYS = np.array([120.0, 900.0])  # s
_SCATTER_PRIOR = 4.0  # bins
STEADY, MOVING, SMOOTH, STROKES = "steady", "transient", "smooth", "stroke"


@dataclass(frozen=True)
class Discrepancy:
    """How far the model itself may be off, in multiples of a sample's noise, by regime of the signal.

    Attributes:
        scale: regime (`STEADY`, `MOVING`, `SMOOTH`, `STROKES`) to standard deviation of a class.
        own: (signal, regime) to the same where a fit found a signal's own.
        scatter: class (signal, regime, kind) to how much more its bins scatter than their noise
            says; beside the mean of a class, single events of it may go otherwise.
        knots: s between the knots of a temperature's smooth curve.
    """

    scale: Mapping[str, float] = field(default_factory=lambda: {STEADY: 0.5, MOVING: 1.5, SMOOTH: 0.25, STROKES: 0.3})
    own: Mapping[tuple[str, str], float] = field(default_factory=dict)
    scatter: Mapping[tuple, float] = field(default_factory=dict)
    knots: float = 150.0

    def of(self, signal: str, regime: str) -> float:
        """Standard deviation of one class of a signal, in multiples of its noise."""
        return self.own.get((signal, regime), self.scale[regime])


@dataclass(frozen=True)
class Block:
    """Rows of one signal: their place, deviations of the bins, allowances.

    Attributes:
        signal: name. rows: slice of the recording's vector. binning: its bins. spread: standard
            deviation of each bin's mean in the signal's unit, (b,).
        kind, load: of a signal whose classes may be off together: index of each bin's class,
            (b,), and the class's allowed deviation in multiples of ``spread``, (b,).
        names: of the classes, (signal, regime, class); the same name in two recordings is the
            same flaw of the model.
        curves: of a signal that may be off by smooth curves, (b, c), else None.
        per_stroke: whether each bin is a stroke.
    """

    signal: str
    rows: slice
    binning: Binning
    spread: np.ndarray
    kind: np.ndarray
    load: np.ndarray
    names: list[tuple]
    curves: np.ndarray | None = None
    per_stroke: bool = False

    @property
    def prompt(self) -> bool:
        """Whether the signal follows at once: it neither remembers nor sums up."""
        return self.curves is None and not self.per_stroke


class Comparison:
    """One recording against predictions of it.

    Args:
        signals: name to signal with ``time``, ``measured``, ``noise``, ``binning``, ``per_stroke``, ``start_std`` of a temperature,
            ``rounding`` if a logger rounds.
        reference: a prediction by which steep places are known.
        discrepancy: what the model is forgiven.

    Attributes:
        blocks: one per signal. size: rows in all. measured: what was measured, over its deviation, (size,).
        spread: that deviation in the signal's unit, (size,).
    """

    def __init__(self, signals: Mapping, reference: Mapping[str, np.ndarray], discrepancy: Discrepancy) -> None:
        self.blocks: list[Block] = []
        self.size = 0
        self._signals = signals
        parts = []
        for name, signal in signals.items():
            binning = signal.binning
            b = binning.count.size
            if b == 0:
                continue
            shared = getattr(signal, "rounding", 0.0) ** 2
            variance = (signal.noise**2 - shared) / binning.count + shared
            if signal.time.size > 2 and not name.startswith(TEMPERATURE_PREFIX) and not signal.per_stroke:
                slope = np.gradient(reference[name], np.maximum.accumulate(signal.time + 1e-9 * np.arange(signal.time.size)))
                variance = variance + CLOCK_JITTER**2 * binning.mean(np.where(np.isfinite(slope), slope, 0.0) ** 2) / binning.count
            spread = np.sqrt(variance)
            rows = slice(self.size, self.size + b)
            if name.startswith(TEMPERATURE_PREFIX):
                nothing = np.zeros(0)
                self.blocks.append(Block(name, rows, binning, spread, nothing, nothing, [], _curves(name, signal, spread, discrepancy)))
            else:
                which, names = _classes(name, signal)
                spread = spread * np.array([discrepancy.scatter.get(n, 1.0) for n in names])[which]
                scale = np.array([discrepancy.of(name, own) for _, own, _ in names])
                self.blocks.append(Block(name, rows, binning, spread, which, scale[which] * signal.noise / spread, names,
                                         per_stroke=signal.per_stroke))
            parts.append(binning.mean(np.where(np.isfinite(signal.measured), signal.measured, 0.0)) / spread)
            self.size += b
        self.measured = np.concatenate(parts) if parts else np.zeros(0)
        self.spread = np.concatenate([block.spread for block in self.blocks]) if parts else np.zeros(0)

    def noise(self, signal: str) -> float:
        """Noise of one sample of a signal, in its unit."""
        return self._signals[signal].noise

    def features(self, prediction: Mapping[str, np.ndarray]) -> np.ndarray:
        """A prediction as the numbers that it is compared by, (size,)."""
        out = np.empty(self.size)
        for block in self.blocks:
            out[block.rows] = block.binning.mean(prediction[block.signal]) / block.spread
        return out

    def residual(self, prediction: Mapping[str, np.ndarray]) -> np.ndarray:
        """Measured less predicted, (size,)."""
        return self.measured - self.features(prediction)


def scatter_of(comparison: Comparison, residual: np.ndarray, widened: Mapping[tuple, float] | None = None) -> dict[tuple, float]:
    """How much each class scatters about its own mean, over what its deviations say, not below 1.

    Args:
        residual: of the comparison, (size,). widened: class to the scatter that its deviations hold already and that is to be counted
            in, see `Discrepancy.scatter`.
    """
    found: dict[tuple, float] = {}
    for block in comparison.blocks:
        if block.curves is not None:
            continue
        own = residual[block.rows] * np.array([(widened or {}).get(name, 1.0) for name in block.names])[block.kind]
        count = np.bincount(block.kind)
        mean = np.bincount(block.kind, own) / count
        square = np.bincount(block.kind, (own - mean[block.kind]) ** 2)
        degrees = np.maximum(count - 1, 1) + _SCATTER_PRIOR  # a few bins say little: drawn towards 1
        factor = np.sqrt((square + _SCATTER_PRIOR) / degrees)
        found.update({name: float(max(1.0, f)) for name, f in zip(block.names, factor, strict=True)})
    return found


def sized(discrepancy: Discrepancy, allowances: dict[tuple, tuple[float, float]]) -> Discrepancy:
    """The same allowances with the size that a fit found them to have (one step of expectation maximisation), not below a third."""
    groups: dict[tuple[str, str], list[float]] = {}
    for name, (value, variance) in allowances.items():
        if name[1] in discrepancy.scale:
            groups.setdefault((name[0], name[1]), []).append(value * value + variance)
    own = {key: discrepancy.of(*key) * max(1.0 / 3.0, float(np.sqrt(np.mean(squares)))) for key, squares in groups.items()}
    return replace(discrepancy, own={**discrepancy.own, **own})


def _regime(signal) -> np.ndarray:
    """Regime of each bin of a signal, (b,)."""
    phase = signal.binning.phase
    if signal.per_stroke:
        return np.full(phase.size, STROKES, dtype=object)
    return np.where(phase == TRANSIENT, MOVING, STEADY).astype(object)


def _classes(name: str, signal) -> tuple[np.ndarray, list[tuple]]:
    """Index of the class of each bin, (b,), and the classes' names."""
    regime = _regime(signal)
    kinds, first, which = np.unique(signal.binning.kind, return_index=True, return_inverse=True)
    return which, [(name, regime[k], int(kind)) for kind, k in zip(kinds, first, strict=True)]


def _curves(name: str, signal, spread: np.ndarray, discrepancy: Discrepancy) -> np.ndarray:
    """Hat functions over time, and what an error of the first reading leaves as it decays, (b, c)."""
    time = signal.binning.time
    knots = np.arange(0.0, (time[-1] if time.size else 0.0) + discrepancy.knots, discrepancy.knots)
    hats = np.maximum(0.0, 1.0 - np.abs(time[:, None] - knots) / discrepancy.knots) * discrepancy.of(name, SMOOTH)
    starts = signal.start_std * np.exp(-time[:, None] / _START_DECAYS)
    return np.hstack([signal.noise * hats, starts]) / spread[:, None]
