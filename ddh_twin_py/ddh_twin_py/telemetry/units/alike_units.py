"""Temperatures that begin where one begins that is refused for its unit: a device that reads all of them has one unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording, Stream
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, ZERO_CELSIUS, UnitMistake, signals_of

FIRST = 10
"""Readings of the begin."""
_ALIKE = 2.25  # K in the right unit, by which places of a unit that has rested differ at most
_USUAL = ZERO_CELSIUS + 25.0  # K at which a machine is likely, of which nothing tells how warm it is
_LEAST, _SHARE = 3, 0.5  # others that begin alike, and their share of all others: no warm unit is as warm everywhere
_LARGEST = 1.0e6  # K, beyond which a number is no temperature in any unit
_FROM_RANGE = 20.0  # K within its range, at most, where one begins that is refused for its unit from the begin on


def alike_units(recording: Recording, refused: Mapping[str, UnitMistake]) -> dict[str, Finding]:
    """What is said of each topic that is likely in the unit of a refused one.

    Args:
        recording: as read. refused: temperature topics, relative, and the unit in which each looks as if given.
    """
    streams, first = dict(recording.streams()), first_readings(recording)
    found: dict[str, Finding] = {}
    for topic, said in begun_alike(first, refused).items():
        (signal,) = signals_of(topic)
        name, stream = f"{recording.namespace}/{topic}", streams[topic]
        found[topic] = Finding("error", recording.path, name, signal.field, signal.to_message(first[topic]), len(stream),
                               f"{recording.path}: {name} {said}", float(stream.time.min()))
    return found


def likely_units(first: Mapping[str, float], refused: Mapping[str, tuple[UnitMistake, ...]]) -> dict[str, UnitMistake]:
    """The unit in which each refused topic is likeliest, of those in which it may be: of those in which all of them may be, as one device
    has one unit, the one in which it begins about as warm as the others do.

    Args:
        first: as of `begun_alike`. refused: temperature topics, relative, and the units in which they look as if given.
    """
    common = set.intersection(*(set(units) for units in refused.values())) if refused else set()
    others = [value for topic, value in first.items() if topic not in refused]
    usual = float(np.median(others)) if others else _USUAL
    return {topic: min([unit for unit in units if unit in common] or units, key=lambda unit: abs(unit.corrected(first[topic]) - usual))
            if topic in first else units[0] for topic, units in refused.items()}


def of_any_unit(read: np.ndarray) -> np.ndarray:
    """Which readings, K as read, may be temperatures in whatever unit, bool[n]."""
    return np.abs(read) < _LARGEST


def first_readings(recording: Recording) -> dict[str, float]:
    """What each temperature topic, relative, reads at its begin, K as read; none of a topic that has no number."""
    return {topic: told for topic, stream in recording.streams()
            if topic.startswith(TEMPERATURE_PREFIX) and np.isfinite(told := _begin(stream))}


def begun_alike(first: Mapping[str, float], refused: Mapping[str, UnitMistake]) -> dict[str, str]:
    """What is said of each topic that is likely in the unit of a refused one, behind its name.

    Args:
        first: what each temperature topic, relative, reads at its begin, K as read. refused: as of `alike_units`.
    """
    found: dict[str, str] = {}
    others = [topic for topic in first if topic not in refused]
    for one, unit in refused.items():
        if one not in first or not _mistaken_from_begin(one, first[one]):
            continue
        alike = [topic for topic in others if abs(first[topic] - first[one]) <= _ALIKE * abs(unit.factor)]
        if len(alike) < max(_LEAST, _SHARE * len(others)):
            continue
        for topic in alike:
            (signal,) = signals_of(topic)
            found[topic] = (f"{signal.field} looks as if given in {unit.unit}, expected is {signal.message_unit}: it begins with "
                            f"{signal.to_message(first[topic]):.1f}, as {len(alike)} of {len(others)} others do beside {one} that is "
                            f"refused as being in {unit.unit}, with {signal.to_message(first[one]):.1f}; not used")
    return found


def _mistaken_from_begin(topic: str, first: float) -> bool:
    """Whether a refused topic was in another unit when it began, K as read, as it began out of its range or near that."""
    (signal,) = signals_of(topic)
    return not signal.lowest + _FROM_RANGE <= first <= signal.highest - _FROM_RANGE


def _begin(stream: Stream) -> float:
    """What a stream reads at its begin, K, NaN where it has no number."""
    values = stream.values[np.argsort(stream.time, kind="stable"), 0]
    known = values[of_any_unit(values)][:FIRST]
    return float(np.median(known)) if known.size else float("nan")
