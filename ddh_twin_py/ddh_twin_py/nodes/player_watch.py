"""Whether a bag player still plays: what is held up comes later, and is not over."""

from __future__ import annotations

from ddh_msgs.msg import PlayerStatus
from ddh_twin_py.nodes import qos
from ddh_twin_py.nodes.node_base import TwinNode

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
        if status is None or status.paused or status.ended or wall - self._heard > GONE:
            return False
        return self._node.count_publishers(self._subscription.topic_name) > 0
