"""Temperatures that begin where one begins that is refused for its unit: a device that reads all of them has one unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording, Stream
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, UnitMistake, signals_of

FIRST = 10
"""Readings of the begin."""
_ALIKE = 4.0  # K as read, by which places of a unit that has rested differ at most
_LEAST, _SHARE = 3, 0.5  # others that begin alike, and their share of all others: no warm unit is as warm everywhere
_FROM_RANGE = 20.0  # K within its range, at most, where one begins that is refused for its unit from the begin on


def alike_units(recording: Recording, refused: Mapping[str, UnitMistake]) -> dict[str, Finding]:
    """What is said of each topic that is likely in the unit of a refused one.

    Args:
        recording: as read. refused: temperature topics, relative, and the units in which they look as if given.
    """
    streams = {topic: stream for topic, stream in recording.streams() if topic.startswith(TEMPERATURE_PREFIX)}
    first = {topic: told for topic, stream in streams.items() if np.isfinite(told := _begin(stream))}
    found: dict[str, Finding] = {}
    for topic, said in begun_alike(first, refused).items():
        (signal,) = signals_of(topic)
        name, stream = f"{recording.namespace}/{topic}", streams[topic]
        found[topic] = Finding("error", recording.path, name, signal.field, signal.to_message(first[topic]), len(stream),
                               f"{recording.path}: {name} {said}", float(stream.time.min()))
    return found


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
        alike = [topic for topic in others if abs(first[topic] - first[one]) <= _ALIKE]
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
    known = values[np.isfinite(values)][:FIRST]
    return float(np.median(known)) if known.size else float("nan")
