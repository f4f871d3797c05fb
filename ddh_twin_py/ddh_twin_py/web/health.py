"""How every node and every sensor is, from what the nodes report and from what arrives here."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from ddh_twin_py.names import first_of
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

OK, WARN, ERROR, SILENT = 0, 1, 2, 3
"""Levels: those of `diagnostic_msgs`, and a node that says nothing any more."""
SILENT_AFTER = 3.5  # s of wall time; nodes report once a second
STOPPED_AFTER = 2.0  # s of wall time
_PERIODS = 2.5  # usual pauses between two messages, after which a sensor has stopped
_SEPARATOR = ": "


@dataclass(frozen=True)
class Line:
    """One status: level, what it says, the values behind it (key, value), wall time in s at which it came."""

    level: int
    message: str
    values: tuple[tuple[str, str], ...]
    at: float


class Health:
    """What nodes say of themselves. Names are `namespace/node: concern`, as in `/diagnostics`."""

    def __init__(self, expected: Iterable[str] = ()) -> None:
        self._lines: dict[str, dict[str, Line]] = {node: {} for node in expected}

    def take(self, name: str, level: int, message: str, values: Iterable[tuple[str, str]], wall: float) -> None:
        """One status as it came at `wall` in s."""
        node, separator, concern = name.partition(_SEPARATOR)
        self._lines.setdefault(node, {})[concern if separator else ""] = Line(level, message, tuple(values), wall)

    def document(self, wall: float) -> list[dict]:
        """Nodes in the order of their first word: name, level, seconds since they spoke (rounded), lines of concern, level, message."""
        return [self._node(node, lines, wall) for node, lines in self._lines.items()]

    def _node(self, node: str, lines: Mapping[str, Line], wall: float) -> dict:
        told = {"node": node, "level": SILENT, "lines": []}
        if not lines:
            return told | {"message": "not heard of"}
        age = wall - max(line.at for line in lines.values())
        shown = [[concern, line.level, line.message] for concern, line in sorted(lines.items(), key=lambda row: (-row[1].level, row[0]))]
        if age > SILENT_AFTER:
            return told | {"message": f"says nothing any more, for {round(age)} s", "lines": shown}
        worst = max(line.level for line in lines.values())
        bad = [concern for concern, level, _ in shown if level > OK]
        message = first_of(bad, 3) or "well"
        return told | {"level": min(worst, ERROR), "message": message, "lines": shown}

    def values(self, name: str) -> list[tuple[str, str]]:
        """The values behind one status, none where there is no such."""
        node, _, concern = name.partition(_SEPARATOR)
        line = self._lines.get(node, {}).get(concern)
        return list(line.values) if line else []

    def of_topic(self, topic: str, wall: float) -> tuple[int, str]:
        """The worst that any node that still speaks says of one of its inputs."""
        said = [lines[topic] for lines in self._lines.values() if topic in lines and wall - lines[topic].at <= SILENT_AFTER]
        worst = max(said, key=lambda line: line.level, default=None)
        return (OK, "") if worst is None else (min(worst.level, ERROR), worst.message)


@dataclass
class _Arrivals:
    at: list[float] = field(default_factory=list)  # s of wall time of looks that found something
    count: int = 0
    newest: float = math.nan  # s of data
    values: Mapping[str, float] = field(default_factory=dict)


class Sensors:
    """Which sensors come in, from their arrival here and from what the nodes say of them."""

    _OVER = 10.0  # s of wall time over which a rate is counted

    def __init__(self, topics: Iterable[str]) -> None:
        self._arrivals = {topic: _Arrivals() for topic in topics}
        self._counts: dict[str, list[tuple[float, int, float]]] = {topic: [] for topic in self._arrivals}

    def arrived(self, topic: str, count: int, values: Mapping[str, float], stamp: float, wall: float) -> None:
        """`count` messages came at `wall` in s, the last of them with these values by field and this stamp in s."""
        entry = self._arrivals[topic]
        entry.at = [*entry.at[-19:], wall]
        entry.count += count
        entry.newest = stamp
        entry.values = values

    def document(self, health: Health, wall: float, paused: bool) -> list[dict]:
        """Rows of topic, state (ok, warn, error, stopped, paused, absent), why, age in s, rate in 1/s of data."""
        return [self._row(topic, entry, health, wall, paused) for topic, entry in self._arrivals.items()]

    def _row(self, topic: str, entry: _Arrivals, health: Health, wall: float, paused: bool) -> dict:
        row = {"topic": topic, "name": topic.removeprefix(TEMPERATURE_PREFIX).removesuffix("/telemetry"), "rate": None, "age": None}
        if not entry.at:
            return row | {"state": "absent", "why": "nothing has come yet"}
        row |= {"age": round(wall - entry.at[-1], 1), "rate": self._rate(topic, entry, wall)}
        if paused:
            return row | {"state": "paused", "why": "the replay stands still"}
        pauses = [after - before for before, after in zip(entry.at, entry.at[1:], strict=False)]
        limit = max(STOPPED_AFTER, _PERIODS * sorted(pauses)[len(pauses) // 2] if pauses else STOPPED_AFTER)
        if wall - entry.at[-1] > limit:
            return row | {"state": "stopped", "why": f"no message for {wall - entry.at[-1]:.0f} s"}
        missing = [name for name, value in entry.values.items() if not math.isfinite(value)]
        if missing:
            return row | {"state": "error", "why": f"{', '.join(missing)} not a number"}
        level, message = health.of_topic(topic, wall)
        return row | {"state": ("ok", "warn", "error")[level], "why": message if level else "comes in"}

    def _rate(self, topic: str, entry: _Arrivals, wall: float) -> float | None:
        """Messages for each second of their stamps, however fast they are played."""
        counts = self._counts[topic]
        counts.append((wall, entry.count, entry.newest))
        while counts[0][0] < wall - self._OVER:
            counts.pop(0)
        (_, before, first), (_, now, last) = counts[0], counts[-1]
        return float(f"{(now - before) / (last - first):.2g}") if last > first else None
