"""That fields of a topic look as if given in another unit."""

from __future__ import annotations

from dataclasses import dataclass

from ddh_twin_py.telemetry.signals import UnitMistake


@dataclass(frozen=True)
class UnitSuspicion:
    """Verdict: `fields` (columns) look as if given in one of `units`, with the factor by which such a number is too large.

    Without units the reason says how they are wrong, and without fields that some are.
    """

    fields: tuple[int, ...]
    units: tuple[UnitMistake, ...]
    reason: str

    @property
    def unit(self) -> str:
        """All units that fit, in words."""
        return _either([unit.unit for unit in self.units])

    @property
    def factor(self) -> str:
        """Their factors, in words."""
        return _either([f"{unit.factor:.4g}" for unit in self.units])


def _either(words: list[str]) -> str:
    return " or ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
