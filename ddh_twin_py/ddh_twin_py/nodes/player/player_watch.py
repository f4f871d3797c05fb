"""Whether a bag player still plays: what is held up comes later, and is not over."""

from __future__ import annotations

from ddh_msgs.msg import PlayerStatus
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import TwinNode

PLAYER = "bag_player"
GONE = 3.0
"""s of wall time without a word after which a player is gone; it speaks once a second."""


class PlayerWatch:
    """Listens to the player of a node's namespace, where there is one."""

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._status: PlayerStatus | None = None
        self._heard = 0.0
        self._subscription = node.create_subscription(PlayerStatus, f"{PLAYER}/status", self._take, qos.LATCHED)

    def _take(self, status: PlayerStatus) -> None:
        self._status, self._heard = status, self._node.wall()

    def plays(self, wall: float) -> bool:
        """Whether more comes, though it may wait for a slow node meanwhile."""
        status = self._status
        return status is not None and not status.paused and not status.ended and self._there(wall)

    def paused(self, wall: float) -> bool:
        """Whether nothing comes because somebody holds it."""
        return self._status is not None and self._status.paused and not self._status.ended and self._there(wall)

    def holds(self, wall: float) -> bool:
        """Whether nothing is due: it is paused, or came to its end and is still there."""
        return self.paused(wall) or self._status is not None and self._status.ended and self._there(wall)

    def _there(self, wall: float) -> bool:
        return wall - self._heard <= GONE and self._node.count_publishers(self._subscription.topic_name) > 0
