"""Which live temperature topics are in the unit of one that is refused for it, told with their first readings."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.telemetry.alike_units import FIRST, begun_alike, likely_units
from ddh_twin_py.telemetry.clock import Break
from ddh_twin_py.telemetry.screening import StreamScreen
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, UnitMistake

_FEWEST = 3  # readings that say how a topic begins


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
            self.refused.pop(topic, None)
            read = read[back[-1]:]
        if len(begin) < FIRST:
            begin += read[np.isfinite(read)][: FIRST - len(begin)].tolist()

    def judge(self) -> list[str]:
        """Topics that are refused from now on, and were not yet; to be asked once the screens have what was taken."""
        own = {topic: units for topic, screen in self._screens.items() if (units := _units(screen))}
        if not own:
            return []
        first = {topic: float(np.median(begin)) for topic, begin in self._begin.items() if len(begin) >= _FEWEST}
        new = {topic: said for topic, said in begun_alike(first, likely_units(first, own)).items() if topic not in self.refused}
        self.refused |= new
        return list(new)


def _units(screen: StreamScreen) -> tuple[UnitMistake, ...]:
    """The other units in which a temperature topic may be, none where it is in its own."""
    return next(iter((screen.in_another_unit() or screen.begins_in_another_unit(_FEWEST)).values()), ())
