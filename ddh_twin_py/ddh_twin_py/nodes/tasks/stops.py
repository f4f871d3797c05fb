"""Stops of a stream that are its own, and one line in the log for those of several at once."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from itertools import pairwise

from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.telemetry.ticks import LONGEST_GAP

CAME_BACK = "and came back, first after"
"""How a stop is told."""
MOST_STEPS = 8
"""Of a topic's own clock that are remembered, and logged in a minute."""
SETTLES = 15.0
"""s of wall time after which it is known what a stop was; a vote on its topic's clock may take so long."""
_TOGETHER = 2.5  # s of wall time within which topics that stopped are named in one line
_RETURNS = 10.0  # s by which a clock that was alone may come back by less or more


class Stops:
    """Stops of a stream by itself: not where the stamps of all went on much later, its own clock was wrong for a while, or we stood still.

    `count` of those that are known, some seconds, of wall time, later; `first` is the length of the first of them, s.
    """

    def __init__(self) -> None:
        self.count, self.first = 0, 0.0
        self._open: list[tuple[float, float]] = []  # wall time and length of those that are not known yet, s
        self._offs: deque[float] = deque(maxlen=MOST_STEPS)  # s
        self._pauses = 0  # of all until now
        self._paused: list[float] = []  # wall times of the last of them, s, that were no stop of this stream yet

    def clock_was_off(self, off: float) -> None:
        """Its clock, alone, was off by so many s."""
        self._offs.append(off)

    def stood_still(self, length: float) -> None:
        """For so many s this process did nothing, and what came then may be lost."""
        self._offs.append(length)

    def note(self, lengths: Iterable[float], pauses: int, wall: float, settles: float = SETTLES) -> None:
        """Stops of so many s were seen, and so many long pauses of all streams until now; the wait until that is judged is given, s."""
        self._open += [(wall, length) for length in lengths]
        self._paused += [wall] * (pauses - self._pauses)
        self._pauses = pauses
        while self._open and wall - self._open[0][0] >= settles:
            came, length = self._open.pop(0)
            pause = next((at for at in self._paused if abs(at - came) <= settles), None) if length > LONGEST_GAP else None
            if pause is not None:
                self._paused.remove(pause)
            elif not self._of_clock(length):
                self.count, self.first = self.count + 1, self.first or length
        self._paused = [at for at in self._paused if wall - at < 2.0 * settles]

    def _of_clock(self, length: float) -> bool:
        """Whether a stop of so many s is the step of a clock that went off, from one error to another, or back."""
        steps = {*self._offs, *(after - before for before, after in pairwise(self._offs))}
        return any(abs(length - abs(step)) < _RETURNS for step in steps)


class StopsTold:
    """Says in one line which inputs of a node stopped and came back at about the same time, of each input the first time.

    Args:
        node: that logs it.
    """

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._known: set[str] = set()
        self._open: dict[str, float] = {}  # s without a sample, by name
        self._since = 0.0

    def note(self, name: str, first: float, wall: float) -> None:
        """An input, by its name, has stopped, the first time for so many s without a sample."""
        if name in self._known:
            return
        self._known.add(name)
        self._since = self._since if self._open else wall
        self._open[name] = first

    def tell(self, wall: float) -> None:
        """Say what is due."""
        if not self._open or wall - self._since < _TOGETHER:
            return
        lengths = self._open.values()
        after = f"{min(lengths):.3f}" if len(lengths) == 1 else f"{min(lengths):.1f} to {max(lengths):.1f}"
        self._node.get_logger().warning(f"{', '.join(self._open)} stopped {CAME_BACK} {after} s without a sample")
        self._open = {}
