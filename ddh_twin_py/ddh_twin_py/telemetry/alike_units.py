"""Temperatures that begin where one begins that is refused for its unit: a device that reads all of them has one unit."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording, Stream
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, UnitMistake, signals_of

_FIRST = 10  # readings of the begin
_ALIKE = 4.0  # K as read, by which places of a unit that has rested differ at most
_LEAST, _SHARE = 3, 0.5  # others that begin alike, and their share of all others: no warm unit is as warm everywhere


def alike_units(recording: Recording, refused: Mapping[str, UnitMistake]) -> dict[str, Finding]:
    """What is said of each topic that is likely in the unit of a refused one.

    Args:
        recording: as read. refused: temperature topics, relative, and the units in which they look as if given.
    """
    first = {topic: told for topic, stream in recording.streams()
             if topic.startswith(TEMPERATURE_PREFIX) and np.isfinite(told := _begin(stream))}
    found: dict[str, Finding] = {}
    for one, unit in refused.items():
        others = [topic for topic in first if topic not in refused]
        alike = [topic for topic in others if one in first and abs(first[topic] - first[one]) <= _ALIKE]
        if len(alike) < max(_LEAST, _SHARE * len(others)):
            continue
        for topic in alike:
            (signal,) = signals_of(topic)
            name, reads = f"{recording.namespace}/{topic}", signal.to_message(first[topic])
            message = (f"{recording.path}: {name} {signal.field} looks as if given in {unit.unit}, expected is {signal.message_unit}: it "
                       f"begins with {reads:.1f}, as {len(alike)} of {len(others)} others do beside {one} that is refused as being in "
                       f"{unit.unit}, with {signal.to_message(first[one]):.1f}; not used")
            stream = dict(recording.streams())[topic]
            found[topic] = Finding("error", recording.path, name, signal.field, reads, len(stream), message, float(stream.time.min()))
    return found


def _begin(stream: Stream) -> float:
    """What a stream reads at its begin, K, NaN where it has no number."""
    values = stream.values[np.argsort(stream.time, kind="stable"), 0]
    known = values[np.isfinite(values)][:_FIRST]
    return float(np.median(known)) if known.size else float("nan")
