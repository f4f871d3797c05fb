"""What finding a place asks of a rig's model."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.locate.lacking import Course
from ddh_twin_py.gap.locate.leftover import FreeForm
from ddh_twin_py.gap.model import DescribedModel


class Locatable(DescribedModel, Protocol):
    """A model whose places are known: where effects act, and where something unknown may."""

    def course(self, effect: Effect, without: np.ndarray, acting: np.ndarray) -> Course:
        """What an effect adds at its place over the first recording in which effects act; parameter records (1,)."""
        ...

    def free_places(self, found: Found, forms: list[FreeForm], off: str = "") -> list[FreePlace]:
        """Places where something unknown may act, the likeliest first, at least one.

        Args:
            forms: free-form discrepancies beside the best listed hypothesis, that which speaks loudest first. off: signal that surely is
                off, which a place has to explain; empty where none is sure.
        """
        ...

    def best_place(self, linearised: Linearised) -> FreePlace | None:
        """The place whose listed effects explain most where they are free; None where nothing is known of places."""
        ...
