"""What is asked of the recordings of a rig: which of some effects act, by a model whose laws are forgiven so much."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from ddh_twin_py.estimation.fitting.comparison import Discrepancy
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.hypotheses import (
    POWER,
    POWER_WITHOUT_COMMISSIONING,
    SLACK,
    WIDTHS,
    WIDTHS_WITHOUT_COMMISSIONING,
)
from ddh_twin_py.gap.model import Model


@dataclass(frozen=True)
class Question:
    """A question; it stays the same at whatever place of the parameters it is asked.

    Attributes:
        model: of the rig, with its recordings. effects: that may act. discrepancy: what the model is forgiven.
        slack: see `hypotheses.SLACK`.
    """

    model: Model
    effects: Sequence[Effect]
    discrepancy: Discrepancy = field(default_factory=Discrepancy)
    slack: float = SLACK

    @property
    def power(self) -> float:
        """Power of the likelihood, with or without a recording of the rig as built; see `hypotheses.POWER`."""
        return POWER_WITHOUT_COMMISSIONING if all(self.model.altered) else POWER

    @property
    def widths(self) -> tuple[float, ...]:
        """Widths of the departures' prior, with or without such a recording; see `hypotheses.WIDTHS`."""
        return WIDTHS_WITHOUT_COMMISSIONING if all(self.model.altered) else WIDTHS

    def forgiving(self, discrepancy: Discrepancy) -> Question:
        """The same of a model that is forgiven so much."""
        return replace(self, discrepancy=discrepancy)
