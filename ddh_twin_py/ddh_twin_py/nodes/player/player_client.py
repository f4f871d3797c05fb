"""What a person asks of the bag player, from any thread to its services and back."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from queue import Empty, SimpleQueue

from rclpy.client import Client
from std_srvs.srv import SetBool

from ddh_msgs.srv import Seek, SetRate
from ddh_twin_py.names import cited
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.nodes.player.player_watch import PLAYER

_SHOWN = 40  # characters of a value that is none


@dataclass(frozen=True)
class _Verb:
    client: Client
    request: Callable[[object], object]


class PlayerClient:
    """Verbs `pause` (true, false), `seek` (s after the start of the bag) and `rate` (times real time)."""

    def __init__(self, node: TwinNode) -> None:
        self._node = node
        self._asked: SimpleQueue[tuple[str, object, Future[str]]] = SimpleQueue()
        self._verbs = {
            "pause": _Verb(node.create_client(SetBool, f"{PLAYER}/pause"), lambda value: SetBool.Request(data=_truth(value))),
            "seek": _Verb(node.create_client(Seek, f"{PLAYER}/seek"), lambda value: Seek.Request(offset=float(value))),
            "rate": _Verb(node.create_client(SetRate, f"{PLAYER}/set_rate"), lambda value: SetRate.Request(rate=float(value))),
        }

    def ask(self, name: str, value: object) -> Future[str]:
        """Ask from any thread; the future holds '' or why it was refused."""
        answer: Future[str] = Future()
        self._asked.put((name, value, answer))
        return answer

    def work(self) -> None:
        """Pass on what was asked; to be called by the node now and then."""
        while True:
            try:
                name, value, answer = self._asked.get_nowait()
            except Empty:
                return
            if answer.set_running_or_notify_cancel():  # else whoever asked has left
                self._pass_on(name, value, answer)

    def _pass_on(self, name: str, value: object, answer: Future[str]) -> None:
        verb = self._verbs.get(name)
        if verb is None:
            answer.set_result(f"there is no {cited(name)}; valid are {', '.join(self._verbs)}")
            return
        try:
            request = verb.request(value)
        except (TypeError, ValueError, OverflowError, AssertionError):
            answer.set_result(f"{name}: value is {str(value)[:_SHOWN]!r}, it must be {'true or false' if name == 'pause' else 'a number'}")
            return
        if not verb.client.service_is_ready():
            answer.set_result(f"nobody plays a bag in {self._node.get_namespace()}")
            return
        verb.client.call_async(request).add_done_callback(lambda future: _settle(answer, future))


def _truth(value: object) -> bool:
    """The value, where it is true or false and nothing that Python would take for it."""
    if not isinstance(value, bool):
        raise TypeError
    return value


def _settle(answer: Future[str], future: object) -> None:
    if future.exception() is not None:
        answer.set_result(str(future.exception()))
        return
    response = future.result()
    answer.set_result("" if response.success else response.message)
