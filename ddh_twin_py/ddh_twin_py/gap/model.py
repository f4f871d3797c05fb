"""What the diagnosis asks of a rig's model: the protocol by which any rig can be diagnosed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import numpy as np

from ddh_twin_py.gap.effect import Effect

Acting = Sequence[tuple[Effect, int, float]]
"""Effects that act: effect, index of its law, departure."""


class Model(Protocol):
    """A rig's model with its recordings.

    Attributes:
        signals: by recording, name to signal (``time`` s, ``measured``, ``noise``, ``unit``, ``binning``).
        altered: by recording, whether effects act in it; they do not in a commissioning recording.
        size: number of parameters.
    """

    signals: Sequence[Mapping]
    altered: Sequence[bool]
    size: int

    def within(self, theta: np.ndarray) -> np.ndarray:
        """Deviations (k,) brought within what tolerances and laws allow."""
        ...

    def run(self, theta: np.ndarray, acting: Acting) -> list[dict[str, np.ndarray]]:
        """Free run of every recording: signal to predictions at its samples."""
        ...

    def run_one(self, number: int, theta: np.ndarray, acting: Acting, roughly: bool = False) -> dict[str, np.ndarray]:
        """The same of one recording; ``roughly`` where only differences between two such runs matter."""
        ...

    def sensitivities(self, pool: ThreadPoolExecutor, theta: np.ndarray, comparisons: Sequence, numbers: Sequence[int],
                      progress=None) -> list[np.ndarray]:
        """Differences of features by every deviation, of the recordings ``numbers``, no effect acting, (rows, k) each."""
        ...
