"""What a free run leaves unexplained, as numbers of known noise and known allowance for the model's own flaws.

Each bin of each signal gives one number, the mean residual over its standard deviation. No model
of a rig fits to its sensors' noise, so every class of bins may be off together by a little (the
discrepancy), and temperatures by a smooth curve. These allowances are random effects: they are
estimated with everything else, and what they can explain counts for nothing.

Kennedy & O'Hagan, Bayesian calibration of computer models, J. R. Statist. Soc. B 63 (2001) 425.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.estimation.binning import TRANSIENT, Binning

CLOCK_JITTER = 1.0e-3
"""s, standard deviation of a stamp; a steep signal is less certain by it."""
_START_DECAYS = np.array([120.0, 900.0])  # s
_START_ERROR = 0.35  # of a reading's noise, what the mean of the first ones leaves
STEADY, MOVING, SMOOTH, STROKES = "steady", "transient", "smooth", "stroke"


@dataclass(frozen=True)
class Discrepancy:
    """How far the model itself may be off, in multiples of a sample's noise, by regime of the signal.

    Attributes:
        scale: regime (`STEADY`, `MOVING`, `SMOOTH`, `STROKES`) to standard deviation of a class.
        own: (signal, regime) to the same where a fit found a signal's own.
        knots: s between the knots of a temperature's smooth curve.
    """

    scale: Mapping[str, float] = field(default_factory=lambda: {STEADY: 0.5, MOVING: 1.5, SMOOTH: 0.25, STROKES: 0.3})
    own: Mapping[tuple[str, str], float] = field(default_factory=dict)
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
    """

    signal: str
    rows: slice
    binning: Binning
    spread: np.ndarray
    kind: np.ndarray
    load: np.ndarray
    names: list[tuple]
    curves: np.ndarray | None = None


class Comparison:
    """One recording against predictions of it.

    Args:
        signals: name to signal with ``time``, ``measured``, ``noise``, ``binning``.
        reference: a prediction by which steep places are known.
        discrepancy: what the model is forgiven.

    Attributes:
        blocks: one per signal. size: rows in all. measured: what was measured, over its deviation, (size,).
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
            variance = signal.noise**2 / binning.count
            if signal.time.size > 2 and name.split("/")[0] != "temperature" and name != "rod_position":
                slope = np.gradient(reference[name], np.maximum.accumulate(signal.time + 1e-9 * np.arange(signal.time.size)))
                variance = variance + CLOCK_JITTER**2 * binning.mean(np.where(np.isfinite(slope), slope, 0.0) ** 2) / binning.count
            spread = np.sqrt(variance)
            rows = slice(self.size, self.size + b)
            if name.startswith("temperature/"):
                nothing = np.zeros(0)
                self.blocks.append(Block(name, rows, binning, spread, nothing, nothing, [], _curves(name, signal, spread, discrepancy)))
            else:
                self.blocks.append(Block(name, rows, binning, spread, *_classes(name, signal, spread, discrepancy)))
            parts.append(binning.mean(np.where(np.isfinite(signal.measured), signal.measured, 0.0)) / spread)
            self.size += b
        self.measured = np.concatenate(parts) if parts else np.zeros(0)

    def features(self, prediction: Mapping[str, np.ndarray]) -> np.ndarray:
        """A prediction as the numbers that it is compared by, (size,)."""
        out = np.empty(self.size)
        for block in self.blocks:
            out[block.rows] = block.binning.mean(prediction[block.signal]) / block.spread
        return out

    def residual(self, prediction: Mapping[str, np.ndarray]) -> np.ndarray:
        """Measured less predicted, (size,)."""
        return self.measured - self.features(prediction)


def _regime(name: str, phase: np.ndarray) -> np.ndarray:
    if name == "rod_position":
        return np.full(phase.size, STROKES, dtype=object)
    return np.where(phase == TRANSIENT, MOVING, STEADY).astype(object)


def _classes(name: str, signal, spread: np.ndarray, discrepancy: Discrepancy) -> tuple[np.ndarray, np.ndarray, list[tuple]]:
    regime = _regime(name, signal.binning.phase)
    kinds, first, which = np.unique(signal.binning.kind, return_index=True, return_inverse=True)
    names = [(name, regime[k], int(kind)) for kind, k in zip(kinds, first, strict=True)]
    scale = np.array([discrepancy.of(name, own) for _, own, _ in names])
    return which, scale[which] * signal.noise / spread, names


def _curves(name: str, signal, spread: np.ndarray, discrepancy: Discrepancy) -> np.ndarray:
    """Hat functions over time, and what an error of the first reading leaves as it decays, (b, c)."""
    time = signal.binning.time
    knots = np.arange(0.0, (time[-1] if time.size else 0.0) + discrepancy.knots, discrepancy.knots)
    hats = np.maximum(0.0, 1.0 - np.abs(time[:, None] - knots) / discrepancy.knots) * discrepancy.of(name, SMOOTH)
    starts = _START_ERROR * np.exp(-time[:, None] / _START_DECAYS)
    return np.hstack([hats, starts]) * (signal.noise / spread[:, None])
