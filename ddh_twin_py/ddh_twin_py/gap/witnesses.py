"""Which signals of a rig a small flaw of the model's laws moves far, so that they bear witness less surely than others."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

_NEEDED = 25.0
UNSHOWN = 33.0
"""Log evidence that a free form must gain besides where no commissioning recording showed how well the laws hold."""
_PAID, USUAL = 10.0, 700.0
"""Log evidence that a free form pays where nothing is to be found, and s of recording for which needs are given: beyond what it pays, what
it gains by flaws of the laws grows with the recording."""


@dataclass(frozen=True)
class Witnesses:
    """How far the signals of a rig can be believed beside a model whose laws are a little wrong.

    A signal whose name begins with ``temperature/`` is slow: it remembers how the rig began.

    Attributes:
        summing: signals that sum up small flaws, as a stroke sums up flows, with the log evidence that a free form of each must gain over
            the best listed hypothesis to be as likely as it, where a commissioning recording showed how well the laws hold.
        amplified: of these, those by which the size of an effect is not judged where others show it at all.
        needed: that log evidence of every other signal. needed_beside_none: the same beside no effect, which has no law that is off.
    """

    summing: Mapping[str, float] = field(default_factory=dict)
    amplified: Collection[str] = ()
    needed: float = _NEEDED
    needed_beside_none: float = _NEEDED

    def needed_of(self, signal: str, effects: int, shown: bool, seconds: float = USUAL) -> float:
        """Log evidence that a free form of a signal must gain to be as likely as the best listed hypothesis.

        Args:
            effects: of which that hypothesis consists. shown: whether a commissioning recording showed how well the laws hold.
            seconds: that recordings with effects last, s.
        """
        usual = self.summing.get(signal, self.needed if effects else self.needed_beside_none)
        least = (usual + _PAID) * max(1.0, seconds / USUAL) - _PAID
        return least if shown else least + UNSHOWN

    def but_summing(self, over: Mapping[str, float]) -> dict[str, float]:
        """By signal, without those that sum up small flaws; all where there are no others."""
        return {name: value for name, value in over.items() if name not in self.summing} or dict(over)

    def prompt(self, over: Mapping[str, float]) -> dict[str, float]:
        """By signal, those alone that follow at once: neither slow nor summing."""
        return {name: value for name, value in over.items() if not _slow(name) and name not in self.summing}

    def slow(self, over: Mapping[str, float]) -> dict[str, float]:
        """By signal, those alone that are slow and not amplified."""
        return {name: value for name, value in over.items() if _slow(name) and name not in self.amplified}


def _slow(signal: str) -> bool:
    return signal.startswith(TEMPERATURE_PREFIX)
