"""Two temperature sensors that read what the twin expects of each other: their connectors were likely exchanged.

A commissioning recording with the sensors in their places is what tells it. The twin then knows the two courses apart, and in the field
recording each reading follows the other's. An effect that moves heat between the two places would bring them nearer, and not across.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.model import Model
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

PROBABILITY = 0.9
"""That two sensors are exchanged, where they read so: a listed effect with such a course in both places is a rare accident."""
_OFF = 3.0  # noises by which each of two readings must be off its own place
_NEARER = 0.5  # of that, by which each must be at most off the other's
_AS_WELL = 1.25  # times what the leading hypothesis leaves of both, up to which an exchange explains them as well


@dataclass(frozen=True)
class Exchanged:
    """Two signals, and how far both together are off their own places and off each other's, in noises."""

    signals: tuple[str, str]
    own: float
    other: float

    @property
    def said(self) -> str:
        """As a question."""
        one, two = self.signals
        return (f"{one} and {two} are {self.own:.1f} times their noise off what the rig as commissioned would show and {self.other:.1f} "
                "times off what it would show of each other; are the two sensors exchanged?")


def exchanged(model: Model, plain: np.ndarray, leader: Refitted) -> Exchanged | None:
    """The two sensors that read each other's places best, None where no two do.

    Args:
        plain: parameters of the rig as commissioned, (k,). leader: the best listed hypothesis, which must not explain both much better.
    """
    numbers = [number for number, acts in enumerate(model.altered) if acts]
    runs = [model.run_one(number, plain, ()) for number in numbers]
    beside = [leader.predictions[number] for number in numbers]
    signals = [model.signals[number] for number in numbers]
    names = [name for name in signals[0] if name.startswith(TEMPERATURE_PREFIX) and all(name in own for own in signals)]
    off = {name: _off(signals, runs, name, name) for name in names}
    far = [name for name in names if off[name] > _OFF]
    found = []
    for one, two in itertools.combinations(far, 2):
        across = _off(signals, runs, one, two), _off(signals, runs, two, one)
        if max(across[0] / off[one], across[1] / off[two]) > _NEARER:
            continue
        both, by_leader = np.hypot(*across), np.hypot(_off(signals, beside, one, one), _off(signals, beside, two, two))
        if both <= _AS_WELL * by_leader:
            found.append(Exchanged((one, two), float(np.hypot(off[one], off[two])) / np.sqrt(2.0), float(both) / np.sqrt(2.0)))
    return min(found, key=lambda one: one.other / one.own, default=None)


def first_of_both(found: Exchanged, places: Sequence[FreePlace]) -> list[FreePlace]:
    """Places with that of the reading first that is one of the two, where it is among them."""
    own = [place for place in places if place.signal in found.signals]
    rest = [place for place in places if place.signal not in found.signals]
    whole = sum(place.share for place in rest) or 1.0
    scaled = [replace(place, share=(1.0 - PROBABILITY) * place.share / whole) for place in rest]
    return [replace(own[0], share=PROBABILITY), *scaled] if own else list(places)


def _off(signals: Sequence[Mapping], runs: Sequence[Mapping[str, np.ndarray]], read: str, of: str) -> float:
    """RMS, in noises, by which a reading is off what runs show of a place; of recordings without a reading nothing counts."""
    squares = []
    for own, run in zip(signals, runs, strict=True):
        signal, there = own[read], own[of]
        order = np.argsort(there.time, kind="stable")
        shown = np.interp(signal.time, there.time[order], run[of][order])
        used = np.isfinite(signal.measured) & (signal.binning.bin >= 0)
        if used.any():
            squares.append(np.mean(((signal.measured - shown)[used] / signal.noise) ** 2))
    return float(np.sqrt(np.mean(squares))) if squares else 0.0
