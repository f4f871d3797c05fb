"""One recording of a rig with the free run over it: what each rig writes for itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from copy import copy
from dataclasses import replace

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Signal


class Run(ABC):
    """One recording of a rig and the free run over it.

    Attributes:
        name: for people. signals: what is compared, name to `estimation.fitting.experiment.Signal`; samples later than a signal's
            ``held_from`` take no part in finding or fitting and must be in none of its bins.
    """

    name: str
    signals: Mapping[str, Signal]

    @abstractmethod
    def predict(self, record: np.ndarray) -> dict[str, np.ndarray]:
        """What every sample of every signal should have read, from a parameter record (1,)."""

    def variables(self, record: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """On what a gap may depend: name with unit, such as ``level, V``, to times (s, increasing, (m,)) and values (m,)."""
        return {}

    def measuring(self, measured: Mapping[str, np.ndarray]) -> Run:
        """The same run with other measurements, (n,) each."""
        other = copy(self)
        other.signals = {name: replace(signal, measured=measured[name]) for name, signal in self.signals.items()}
        return other
