"""Tell how far a node has come, so that a player can wait for it."""

from __future__ import annotations

from ddh_msgs.msg import NodeProgress
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.inputs import Inputs
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.nodes.base.times import set_time

TOPIC = "progress"
_DATA_STEP = 200_000_000  # ns of data
_WALL_STEP = 0.1  # s
_ALIVE_STEP = 1.0  # s, where nothing changes


class Progress:
    """Publishes `progress` every 0.2 s of data, every 0.1 s of wall time in which data came, and once a second."""

    def __init__(self, node: TwinNode, inputs: Inputs) -> None:
        self._node = node
        self._inputs = inputs
        self._publisher = node.create_publisher(NodeProgress, TOPIC, qos.OUTPUT)
        self._told_wall = -_ALIVE_STEP
        self._told_ns = 0
        self._told_count = 0

    def tell(self, wall: float) -> None:
        """Publish if it is time; to be called after the work on what was received is done."""
        entries = list(self._inputs.all.values())
        newest = max((entry.newest_ns for entry in entries), default=0)
        count = sum(entry.received for entry in entries)
        waited = wall - self._told_wall
        changed = count != self._told_count
        if not (waited >= _ALIVE_STEP or changed and (waited >= _WALL_STEP or abs(newest - self._told_ns) >= _DATA_STEP)):
            return
        self._told_wall, self._told_ns, self._told_count = wall, newest, count
        message = NodeProgress(
            node=self._node.get_fully_qualified_name(),
            topics=[entry.name for entry in entries],
            received=[entry.received for entry in entries],
            rejected=[entry.rejected for entry in entries],
            newest=[entry.newest_ns for entry in entries],
        )
        set_time(message.header.stamp, newest)
        self._publisher.publish(message)
