"""Where a bag is played, and which of its messages are due."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ddh_twin_py.nodes.player.flow_control import FlowControl
from ddh_twin_py.sources.raw_bag import RawBag, RawBlock

_BURST = 250_000_000  # ns of data sent at once
_LAG = 1_000_000_000  # ns of data behind the rate asked for, from which on it is said


class Playback:
    """A place in a bag that moves on with the wall clock at a rate, no further than flow control lets it.

    Args:
        bag: that is played. flow: how far its listeners have come. wall: s, of a clock that never jumps. rate: times real time, 0: as
            fast as listeners take it. offset: s after the start of the bag, where each round begins. paused: whether it stands still.

    Attributes:
        stamp_ns: the place, ns of the time in which messages are due. rate, paused: as they are now. waiting: until `start`. sent_all:
            whether the bag was sent to its end. ended: whether that was taken, too, which whoever plays it says. begun: s of wall time at
            which it went on from another place. held: s of wall time in which listeners were slower than the rate asked for.
    """

    def __init__(self, bag: RawBag, flow: FlowControl, wall: Callable[[], float], rate: float, offset: float = 0.0,
                 paused: bool = False) -> None:
        self._bag, self._flow, self._wall, self._offset = bag, flow, wall, offset
        self.rate, self.paused = rate, paused
        self.waiting = True
        self.held = 0.0
        self._held_since: float | None = None  # wall time of the look that sent all that it may, None where that was all that is due
        self._round = 1
        self.seek(offset)

    @property
    def position(self) -> float:
        """s after the start of the bag."""
        return (self.stamp_ns - self._bag.begin_ns) * 1e-9

    @property
    def duration(self) -> float:
        """Length of the bag, s."""
        return self._bag.duration

    def start(self, wall: float) -> None:
        """Play from here: those that were waited for listen."""
        self.waiting = False
        self._begin_here(wall)

    def pause(self, paused: bool) -> None:
        """Stop or go on."""
        if not paused:
            self._anchor()
        self.paused = paused

    def seek(self, offset: float) -> None:
        """Go on from `offset` s after the start of the bag."""
        self.stamp_ns = self._bag.begin_ns + round(offset * 1e9)
        self._blocks: Iterator[RawBlock] = self._bag.blocks(self.stamp_ns)
        self._block: RawBlock | None = None
        self._at = 0
        self._flow.jumped()
        self.sent_all = self.ended = False
        self._begin_here(self._wall())

    def set_rate(self, rate: float) -> None:
        """Go on at another rate."""
        self.rate = rate
        self._anchor()

    def next_round(self) -> int:
        """Begin the bag again; number of the round."""
        self._round += 1
        self.seek(self._offset)
        return self._round

    def since_begin(self, wall: float) -> tuple[float, float]:
        """Data played since it last went on from another place, and the wall time that this took, s each."""
        return (self.stamp_ns - self._begun_ns) * 1e-9, max(wall - self.begun, 1e-9)

    def look(self, wall: float) -> None:
        """Count how long it was held up; to be called now and then, also while it stands."""
        if self._held_since is not None:
            self.held += wall - self._held_since
            self._held_since = None

    def advance(self, wall: float, send: Callable[[RawBlock], None]) -> bool:
        """Send what is due and may be sent.

        Returns:
            Whether listeners keep it more than `_LAG` behind its rate; it is counted anew from here then.
        """
        wanted = self._anchor_ns + round((wall - self._anchor_wall) * self.rate * 1e9)
        due = self.stamp_ns + _BURST
        if self.rate > 0.0:
            due = min(due, wanted)
        limit = self._flow.limit()
        held = limit is not None and limit < due
        if held:
            due = limit
        if due > self.stamp_ns:
            self._send_until(due, send)
        behind = held and self.rate > 0.0 and wanted - due > _LAG
        if behind:
            self._anchor()
        if held:
            self._held_since = self._wall()
        return behind

    def _send_until(self, due_ns: int, send: Callable[[RawBlock], None]) -> None:
        """Send what is due up to `due_ns`."""
        while True:
            if self._block is None or self._at >= len(self._block.messages):
                self._block, self._at = next(self._blocks, None), 0
                if self._block is None:
                    self.stamp_ns = self._bag.end_ns
                    self.sent_all = True
                    return
            stop = int(np.searchsorted(self._block.due, due_ns, side="right"))
            if stop <= self._at:
                break
            send(self._block.part(slice(self._at, stop)))
            self._at = stop
            if stop < len(self._block.messages):
                break
        self.stamp_ns = due_ns

    def _begin_here(self, wall: float) -> None:
        self._anchor()
        self.begun, self._begun_ns = wall, self.stamp_ns

    def _anchor(self) -> None:
        """From here and now on the position follows the wall clock at the rate."""
        self._anchor_wall, self._anchor_ns = self._wall(), self.stamp_ns
