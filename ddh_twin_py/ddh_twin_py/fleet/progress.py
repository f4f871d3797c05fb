"""How far a fleet, or a bench, is, in words: how many are finished, what is under way, and how long the rest may take."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from ddh_twin_py.physics.compiling import COMPILING
from ddh_twin_py.rig.files import printable

_STARTED = 0.005  # share from which it is told in place of the stage
_NAMED = 3  # recordings under way that are named
_SURE = 0.1  # share of what was left, from which on the time that it takes is told


class FleetProgress:
    """Keeps what it is told; `said` puts it into words.

    Args:
        recordings: how many there are. finished: how many of them were when this run began. clock: s.
    """

    def __init__(self, recordings: int, finished: int, clock: Callable[[], float] = time.monotonic) -> None:
        self._recordings, self._finished = recordings, finished
        self.share = finished / recordings
        self._clock, self._since = clock, clock()
        self._moved = self._since  # when the share last changed
        self._before, self._failed = finished, 0
        self._running: Mapping[str, tuple[float, str]] = {}

    def then(self, progress: Callable[[float], None]) -> Callable[[float, Mapping[str, tuple[float, str]], int], None]:
        """What keeps the share of all and of each that is under way, and how many of this run failed, and passes the first on."""

        def told(share: float, running: Mapping[str, tuple[float, str]], failed: int) -> None:
            self._failed = failed
            self._finished = round(share * self._recordings - sum(done for done, _ in running.values()))
            if share != self.share:
                self._moved = self._clock()
            self.share, self._running = share, running
            progress(share)

        return told

    def said(self, share: float) -> str:
        """Such as `2 of 4 finished, crane_3: 41 %, about 12 min left`; of one whose share stands still, what it does."""
        named = [f"{printable(name)}: {stage if done < _STARTED or stage == COMPILING else f'{100.0 * done:.0f} %'}"
                 for name, (done, stage) in sorted(self._running.items())]
        more = [f"{len(named) - _NAMED} more under way"] if len(named) > _NAMED else []
        return ", ".join([f"{self._finished} of {self._recordings} finished", *named[:_NAMED], *more, *self._left()])

    def _left(self) -> list[str]:
        """How long the rest takes, if it goes on as until the share last changed; nothing where that cannot be told yet, or has passed
        without the share going on. What failed tells nothing of that."""
        left = self._recordings * (1.0 - self.share)
        done = self._recordings - self._before - self._failed - left
        if done < _SURE * (done + left) or left <= 0.0:
            return []
        now = self._clock()
        seconds = (self._moved - self._since) * left / done - (now - self._moved)
        if seconds < 0.5:
            return []
        return [f"about {seconds / 60.0:.0f} min left" if seconds >= 90.0 else f"about {seconds:.0f} s left"]
