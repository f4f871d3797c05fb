"""Who must listen before the first message is played, and whether all of them do."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.publisher import Publisher

from ddh_twin_py.names import in_namespace
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.parameters import NodeError
from ddh_twin_py.nodes.player.flow_control import FlowControl

_SETTLE = 0.3  # s of wall time from the last match to the first message
_NAMED_WAIT, _FIRST_START = 60.0, 900.0  # s of wall time for a node that is not there, and for one that is and compiles its kernels
_ANYBODY = "any listener"


class AwaitedListeners:
    """Waits for the listeners of a player.

    Args:
        node: the player. flow: that hears of those that tell their progress. publishers: of what is played.
        named: nodes that must listen, by name in the player's namespace or in full; none: any listener will do.
        wait: longest wall time to wait for any, s. begun: wall time from which that counts, s.
    """

    def __init__(self, node: Node, flow: FlowControl, publishers: Sequence[Publisher], named: Sequence[str], wait: float,
                 begun: float) -> None:
        self._node, self._flow, self._publishers, self._wait, self._begun = node, flow, publishers, wait, begun
        self._named = [in_namespace(node.get_namespace(), name) for name in named if name]
        self._ready_since: float | None = None
        self._lacked: tuple[str, bool] | None = None  # what `_missing` told last
        self._changed = begun  # wall time of its last change
        self._told_starting: set[str] = set()

    def are_there(self, wall: float) -> bool:
        """Whether playing may begin: all listen, or nobody must and none came.

        Raises:
            NodeError: a node that must listen does not, after all that it may take.
        """
        missing, starting = now = self._missing()
        if self._lacked not in (None, now):
            self._changed = wall
        self._lacked = now
        if missing:
            self._ready_since = None
            return self._long_enough(missing, starting, wall)
        if self._ready_since is None:
            self._ready_since = wall
        return wall - self._ready_since >= _SETTLE

    def running(self) -> set[str]:
        """Full names of the nodes of the graph."""
        return {in_namespace(namespace, name) for name, namespace in self._node.get_node_names_and_namespaces()}

    def _long_enough(self, missing: str, starting: bool, wall: float) -> bool:
        """Whether what is missing was waited for as long as it may take."""
        if self._named:
            self._wait_for_named(missing, starting, wall)
            return False
        if wall - self._begun < self._wait:
            return False
        lack = "nobody listens" if missing == _ANYBODY else f"there is no {missing}"
        self._node.get_logger().info(f"{lack} after {self._wait:g} s, playing all the same")
        return True

    def _wait_for_named(self, missing: str, starting: bool, wall: float) -> None:
        """Say once of each node that it is starting; from the last change of what is missing on there is a minute, lest a long wait end
        all at once.

        Raises:
            NodeError: it is over.
        """
        first_start = self._wait + _FIRST_START
        longest = first_start if starting else self._wait + _NAMED_WAIT
        longest = max(longest, min(self._changed - self._begun, first_start) + _NAMED_WAIT)
        waited = wall - self._begun
        if waited >= longest:
            raise NodeError(f"waited {waited:.0f} s for {missing}; is it running, in namespace {self._node.get_namespace()}?")
        if starting and waited >= self._wait and missing not in self._told_starting:
            self._told_starting.add(missing)
            self._node.get_logger().info(f"{missing} is there and not ready yet; a first start compiles the model: waiting for "
                                         f"up to {longest:g} s")

    def _missing(self) -> tuple[str, bool]:
        """What is still awaited, '' when all are there; whether it is a node that runs and has not told its progress yet."""
        if silent := [name for name in self._named if name not in self._flow.consumers]:
            running = self.running()
            name = min(silent, key=running.__contains__)  # one that does not run before one that starts
            return f"node {name}", name in running
        listening = [(publisher.topic_name, self._listening_to(publisher)) for publisher in self._publishers]
        for name in self._named or self._flow.consumers:
            for topic, reliable in listening:
                if topic in self._flow.consumers[name].topics and not reliable.get(name, False):
                    return f"node {name} to listen reliably to {topic}", False
        return ("" if self._named or any(reliable for _, reliable in listening) else _ANYBODY), False

    def _listening_to(self, publisher: Publisher) -> dict[str, bool]:
        """Nodes that subscribe to a topic and are matched; whether they ask for reliable delivery. One that never can be counts not."""
        infos = [info for info in self._node.get_subscriptions_info_by_topic(publisher.topic_name)
                 if qos.can_match(publisher.qos_profile, info.qos_profile)]
        if publisher.get_subscription_count() < len(infos):
            return {}
        return {
            in_namespace(info.node_namespace, info.node_name): info.qos_profile.reliability == qos.OUTPUT.reliability
            for info in infos
        }
