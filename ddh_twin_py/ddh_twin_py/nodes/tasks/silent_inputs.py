"""Says in the log which inputs of a node have fallen silent: who looks at no diagnostics sees that, too."""

from __future__ import annotations

import math
from collections.abc import Callable

from ddh_twin_py.nodes.base.node_base import TwinNode

SILENCE = 10.0
"""s of wall time without a message on an input that came, after which it is silent."""
_TOGETHER = 2.5  # s of wall time within which inputs that fall silent are named in one line
_STOOD = 5.0  # s of wall time between two looks, after which the node itself may have taken nothing in


class SilentInputs:
    """Says in one line which inputs have fallen silent at about the same time, each once until it comes again.

    Args:
        node: that logs it. held: whether nothing is due at a wall time, as a player is paused or at its end.
    """

    def __init__(self, node: TwinNode, held: Callable[[float], bool]) -> None:
        self._node, self._held = node, held
        self._said: set[str] = set()
        self._open: dict[str, float] = {}  # s of wall time at which each was found silent last that is not said yet, by name
        self._since = 0.0  # s of wall time at which the first of them was
        self._looked = self._woke = -math.inf  # s of wall time of the last look, and of the last one after the node stood still

    def note(self, name: str, age: float, usual: float, wall: float) -> None:
        """So old is the last message of an input by its name, s, NaN where none ever came; ``usual``: from which age it is stale, s."""
        if wall - self._looked > _STOOD:
            self._woke = wall
        self._looked = wall
        if not age > max(SILENCE, usual) or self._held(wall):
            self._said.discard(name)
            self._open.pop(name, None)
        elif name not in self._said and wall - self._woke > SILENCE:
            self._since = self._since if self._open else wall
            self._said.add(name)
            self._open[name] = wall
        elif name in self._open:
            self._open[name] = wall
        if self._open and min(self._open.values()) - self._since >= _TOGETHER:  # all were looked at again, also where that took long
            self._node.get_logger().warning(f"nothing comes any more on {', '.join(self._open)}")
            self._open = {}
