"""Data of a described rig that take no part in finding or fitting (`gap.model.Held`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter

import numpy as np

from ddh_twin_py.gap.effect import Acting
from ddh_twin_py.gap.shrink.size import counted
from ddh_twin_py.real_rigs.run import Run


class RigHeld:
    """The held runs of a model, or where it has none the samples of those in question after each signal's ``held_from``.

    Args:
        held, field: runs of either. record: parameter record (1,) of those in question, of deviations (k,) and of what acts.
    """

    def __init__(self, held: Sequence[Run], field: Sequence[Run], record: Callable[[np.ndarray, Acting], np.ndarray]) -> None:
        self._whole, self._record = bool(held), record
        self._runs = held or field
        own = ", ".join(run.name for run in self._runs)
        self.words = own if held else f"the end of {own}, {self._spans()}"

    def _spans(self) -> str:
        first = min(signal.held_from for run in self._runs for signal in run.signals.values())
        last = max(float(signal.time[-1]) for run in self._runs for signal in run.signals.values())
        return f"from {first:.4g} s to {last:.4g} s"

    def signals(self) -> list[Mapping]:
        """Signals by recording."""
        return [run.signals for run in self._runs]

    def mask(self) -> Callable[[object], np.ndarray]:
        """Which samples of a signal count."""
        return counted if self._whole else attrgetter("held_back")

    def open_begins(self) -> list[int]:
        """None: described rigs begin as they are read."""
        return [0] * len(self._runs)

    def run(self, theta: np.ndarray, acting: Acting, begin: Sequence[Sequence[float]] | None = None,
            roughly: bool = False) -> list[dict[str, np.ndarray]]:
        """Free runs, by recording; all begin as they are read, and rough ones are as fine as others."""
        record = self._record(theta, acting)
        return [run.predict(record) for run in self._runs]

    def axes(self, theta: np.ndarray, acting: Acting) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Variables on which residuals may depend, of the first recording."""
        return self._runs[0].variables(self._record(theta, acting))
