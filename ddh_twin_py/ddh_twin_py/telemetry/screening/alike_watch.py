"""Which live temperature topics are in the unit of one that is refused for it, told with their first readings, or odd beside the others."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.screening.screening import StreamScreen
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, ZERO_CELSIUS, UnitMistake
from ddh_twin_py.telemetry.units.alike_units import FIRST, begun_alike, likely_units, of_any_unit
from ddh_twin_py.telemetry.units.temperature_units import LEAST, odd_beside_others

_FEWEST = 3  # readings that say how a topic begins
_MOST = 64  # readings of a topic that are kept, spread over all its time
_WAITED = 60_000_000_000  # ns for which slow ones are waited for
_EVERY = 20_000_000_000  # ns of stamps after which all are held against each other anew


class AlikeWatch:
    """Looks at the first readings of all temperature topics together; where stamps go to an earlier time a topic begins again.

    Args:
        screens: by relative topic.

    Attributes:
        refused: by topic what is said of it, behind its name.
    """

    def __init__(self, screens: Mapping[str, StreamScreen]) -> None:
        self._screens = {topic: screen for topic, screen in screens.items() if topic.startswith(TEMPERATURE_PREFIX)}
        self._begin: dict[str, list[float]] = {topic: [] for topic in self._screens}
        self._kept: dict[str, list[tuple[int, float]]] = {topic: [] for topic in self._screens}  # stamps, ns, and K as read
        self._judged = 0  # newest stamp, ns, when all were held against each other last
        self._last: dict[str, int] = {}  # ns
        self.refused: dict[str, str] = {}

    def take(self, topic: str, stamp: np.ndarray, read: np.ndarray) -> None:
        """Readings of a topic before they are screened: int64[n] ns, K as read, (n,). Of another kind of topic they are passed over."""
        begin = self._begin.get(topic)
        if begin is None or not stamp.size:
            return
        back = np.flatnonzero([Break.of(step * 1e-9) is Break.OTHER_TIME
                               for step in np.diff(stamp, prepend=self._last.get(topic, int(stamp[0]))).tolist()])
        self._last[topic] = int(stamp[-1])
        if back.size:
            begin.clear()
            self._kept[topic].clear()
            self._judged = 0
            self.refused.pop(topic, None)
            stamp, read = stamp[back[-1]:], read[back[-1]:]
        if len(begin) < FIRST:
            begin += read[of_any_unit(read)][: FIRST - len(begin)].tolist()
        self._keep(self._kept[topic], stamp, np.where(of_any_unit(read), read, np.nan))

    def _keep(self, kept: list[tuple[int, float]], stamp: np.ndarray, read: np.ndarray) -> None:
        """Keep readings as far apart as those that are kept."""
        for at, value in zip(stamp.tolist(), read.tolist(), strict=True):
            apart = (kept[-1][0] - kept[0][0]) // _MOST if len(kept) >= _MOST // 2 else 0
            if np.isfinite(value) and (not kept or at > kept[-1][0] + apart):
                kept.append((at, value))
            if len(kept) >= _MOST:
                del kept[1::2]

    def judge(self) -> list[str]:
        """Topics that are refused from now on, and were not yet; to be asked once the screens have what was taken."""
        own = {topic: units for topic, screen in self._screens.items() if (units := _units(screen))}
        new = (self._alike(own) if own else {}) | self._odd(own)
        self.refused |= new
        return list(new)

    def _alike(self, own: Mapping[str, tuple[UnitMistake, ...]]) -> dict[str, str]:
        first = {topic: float(np.median(begin)) for topic, begin in self._begin.items() if len(begin) >= _FEWEST}
        return {topic: said for topic, said in begun_alike(first, likely_units(first, own)).items() if topic not in self.refused}

    def _odd(self, own: Mapping[str, tuple[UnitMistake, ...]]) -> dict[str, str]:
        newest = max(self._last.values(), default=0)
        if newest < self._judged + _EVERY or max(map(len, self._kept.values()), default=0) < LEAST:
            return {}
        slow = {topic: kept[0][0] for topic, kept in self._kept.items() if 0 < len(kept) < LEAST}
        if f"{TEMPERATURE_PREFIX}ambient" in slow or slow and newest < min(slow.values()) + _WAITED:
            return {}  # whether a winding has rested, the air tells
        self._judged = newest
        known = {topic: np.array(kept, np.float64).T for topic, kept in self._kept.items()
                 if len(kept) >= LEAST and topic not in own and topic not in self.refused}
        read = {topic.removeprefix(TEMPERATURE_PREFIX): (1e-9 * at, read - ZERO_CELSIUS) for topic, (at, read) in known.items()}
        return {f"{TEMPERATURE_PREFIX}{name}": f"{text}; not used" for name, text in odd_beside_others(read).items()}


def _units(screen: StreamScreen) -> tuple[UnitMistake, ...]:
    """The other units in which a temperature topic may be, none where it is in its own."""
    return next(iter((screen.in_another_unit() or screen.begins_in_another_unit(_FEWEST)).values()), ())
