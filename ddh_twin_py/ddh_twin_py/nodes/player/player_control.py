"""How a bag player is steered and watched: services, and a status that is told."""

from __future__ import annotations

from std_srvs.srv import SetBool

from ddh_msgs.msg import PlayerStatus
from ddh_msgs.srv import Seek, SetRate
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.nodes.base.times import set_time
from ddh_twin_py.nodes.player.playback import Playback

STATUS_TOPIC = "~/status"
FASTEST = 10000.0  # times real time
_PERIOD = 0.1  # s of wall time between two looks at the status
_ALIVE = 1.0  # s of wall time after which it is told again where nothing has changed
_SPEED_OVER = 1.0  # s of wall time


class PlayerControl:
    """Services `~/pause`, `~/seek`, `~/set_rate` of a player, and its `~/status` ten times a second while it moves."""

    def __init__(self, node: TwinNode, playback: Playback, bag: str, loop: bool) -> None:
        self._node, self._playback = node, playback
        self._status = PlayerStatus(bag=bag, loop=loop)
        self._told = None
        self._told_at = -_ALIVE
        self._passed: list[tuple[float, float]] = []  # wall time and position, s, over the last second
        self._publisher = node.create_publisher(PlayerStatus, STATUS_TOPIC, qos.LATCHED)
        node.create_service(SetBool, "~/pause", self._on_pause)
        node.create_service(Seek, "~/seek", self._on_seek)
        node.create_service(SetRate, "~/set_rate", self._on_set_rate)
        node.every(_PERIOD, self.tell)

    def tell(self) -> None:
        """Publish the status where it has changed, and once a second."""
        playback, wall = self._playback, self._node.wall()
        self._passed = [passed for passed in self._passed if passed[0] > wall - _SPEED_OVER] + [(wall, playback.position)]
        now = (playback.position, playback.rate, playback.paused, playback.waiting, playback.ended)
        if now == self._told and wall - self._told_at < _ALIVE:
            return
        self._told, self._told_at = now, wall
        status = self._status
        status.position, status.rate, status.paused, status.waiting, status.ended = now
        status.duration, status.speed = playback.duration, self._speed()
        set_time(status.header.stamp, playback.stamp_ns)
        self._publisher.publish(status)

    def _speed(self) -> float:
        (from_wall, from_position), (wall, position) = self._passed[0], self._passed[-1]
        return (position - from_position) / (wall - from_wall) if wall > from_wall else 0.0

    def _jumped(self) -> None:
        self._passed.clear()
        self.tell()

    def _on_pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._playback.pause(request.data)
        self.tell()
        response.success = True
        response.message = f"{'paused' if request.data else 'playing'} at {self._playback.position:.3f} s"
        return response

    def _on_seek(self, request: Seek.Request, response: Seek.Response) -> Seek.Response:
        if not 0.0 <= request.offset <= self._playback.duration:
            response.message = f"offset is {request.offset:g} s, allowed are 0 to {self._playback.duration:.3f} s"
            return response
        self._playback.seek(request.offset)
        self._jumped()
        self._node.get_logger().info(f"now at {request.offset:g} s")
        response.success = True
        return response

    def _on_set_rate(self, request: SetRate.Request, response: SetRate.Response) -> SetRate.Response:
        if not 0.0 <= request.rate <= FASTEST:
            response.message = f"rate is {request.rate:g}, allowed are 0 (full speed) to {FASTEST:g}"
            return response
        self._playback.set_rate(request.rate)
        self.tell()
        response.success = True
        return response
