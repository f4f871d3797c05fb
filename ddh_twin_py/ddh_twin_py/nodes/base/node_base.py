"""What every node of the twin shares: parameters, a clean start, a clean stop."""

from __future__ import annotations

import gc
import signal
import sys
from collections.abc import Callable, Iterable

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import get_logger
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.names import short
from ddh_twin_py.nodes.base.parameters import NodeError, Parameter, declare
from ddh_twin_py.physics.compiling import COMPILING, watched
from ddh_twin_py.rig import RigError

NAMESPACE = "ddh"
"""Where a node lives unless it is started with ``-r __ns:=/other``."""

POLL_PERIOD = 0.01
"""s of wall time between two looks at the inputs."""
AGAIN = 60.0
"""s of wall time after which what comes again is said again."""


class TwinNode(Node):
    """A node in the namespace `ddh`, or in the one it was started with.

    `values` holds its parameters by name. A node that has done its work sets `finished`, and
    `exit_code` where that is not 0. `waits_for` are topics without which it tells nothing.
    """

    PARAMETERS: tuple[Parameter, ...] = ()
    waits_for: tuple[str, ...] = ()

    def __init__(self, name: str, extra: Iterable[Parameter] = ()) -> None:
        super().__init__(name, namespace=NAMESPACE)
        self.finished = False
        self.exit_code = 0
        self.wall_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.values = declare(self, (*self.PARAMETERS, *extra))
        self._said: set[object] = set()
        self._met: dict[object, tuple[float, int]] = {}  # wall time of the last line of a cause, how often it was met since

    def wall(self) -> float:
        """Seconds of a clock that never jumps; for waiting and for ages, never for the model."""
        return self.wall_clock.now().nanoseconds * 1e-9

    def every(self, period: float, callback: Callable[[], None]):
        """Call back each `period` s of wall time, also where simulated time stands still."""
        return self.create_timer(period, callback, clock=self.wall_clock)

    def warn_once(self, cause: object, text: str) -> bool:
        """Log a warning the first time that its cause is met; tells whether it was the first."""
        if cause in self._said:
            return False
        self._said.add(cause)
        self.get_logger().warning(text)
        return True

    def warn_again(self, cause: object, text: str) -> bool:
        """Log a warning each time that its cause is met, but in `AGAIN` s once, with how often it went unsaid; tells whether it did."""
        wall = self.wall()
        last, unsaid = self._met.get(cause, (-AGAIN, 0))
        if wall - last < AGAIN:
            self._met[cause] = last, unsaid + 1
            return False
        self._met[cause] = wall, 0
        self.get_logger().warning(text + (f" (and {unsaid} time{'s' * (unsaid > 1)} since this was last said)" if unsaid else ""))
        return True

    def close(self) -> None:
        """Called once before the end, whatever caused it; ROS still works."""


_LONGEST_END = 12  # s from the signal to the end


class _Stop:
    """Set by SIGINT and SIGTERM."""

    def __init__(self) -> None:
        self.asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._ask)  # also where a shell started us with SIGINT ignored

    def _ask(self, number: int, frame: object) -> None:
        if not self.asked:
            signal.alarm(_LONGEST_END)  # whatever hangs on the way out, the process ends
        self.asked = True


def _name(kind: type[TwinNode]) -> str:
    """Of a node's executable."""
    return kind.__module__.rsplit(".", 1)[-1]


def described(kind: type[TwinNode]) -> str:
    """What a node is for, how it is started and its parameters, for who asks with ``--help``."""
    name = _name(kind)
    about = (sys.modules[kind.__module__].__doc__ or "").strip()
    usage = f"usage: ros2 run ddh_twin_py {name} [--ros-args -r __ns:=/NAMESPACE -p PARAMETER:=VALUE ...]"
    rows = [f"  {p.name:<24} {p.description} Default: {p.default!r} {p.unit}".rstrip() for p in kind.PARAMETERS]
    return "\n".join([about, "", usage, "", "parameters:", *rows])


def _say_once(kind: type[TwinNode]) -> Callable[[], None]:
    """What logs that the model is being compiled, the first time it is called."""
    left = [COMPILING]

    def say() -> None:
        if left:
            get_logger(_name(kind)).info(f"{left.pop()}; nothing is told for a minute")

    return say


def _refuse_stray(kind: type[TwinNode], args: list[str] | None) -> None:
    """A node is given parameters and names, in the way of ROS, and nothing else.

    Raises:
        NodeError: there is an argument that ROS does not read.
    """
    stray = remove_ros_args(sys.argv)[1:] if args is None else remove_ros_args(args)
    if stray:
        raise NodeError(f"{_name(kind)} takes no argument {' '.join(map(repr, stray))}; a parameter is given as "
                        "--ros-args -p PARAMETER:=VALUE, --help names all")


def _ready(node: TwinNode) -> str:
    """Where a node lives, the rig sheet that it uses, where it does, and what it waits for."""
    sheet = ""
    if "rig" in node.values:
        sheet = f" with rig sheet {node.values['rig']}" if node.values["rig"] else " with the reference sheet"
    waiting = f", waiting for {', '.join(node.waits_for)}" if node.waits_for else ""
    return f"ready in {node.get_namespace()}{sheet}{waiting}"


def _close_after_failure(node: TwinNode) -> None:
    """Let a node that failed keep what it has; that this fails too is told beside the first failure, and hides it not."""
    try:
        node.close()
    except Exception as error:  # whatever a node that failed is left with
        node.get_logger().error(f"not all could be kept at the end: {error}")


def run(kind: type[TwinNode], args: list[str] | None = None) -> int:
    """Spin a node of a kind that is made without arguments, until it is finished or SIGINT or SIGTERM come; returns the exit code.

    0: stopped or finished; 1: finished, but not all of its work was done, as its log says; 2: what it was given cannot be used, said in one
    line.
    """
    if {"-h", "--help"} & set(sys.argv[1:] if args is None else args):
        print(described(kind))
        return 0
    stop = _Stop()
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:  # ROS arguments or a parameter file that cannot be read
        print(f"error: {str(error).split(', at /')[0]}", file=sys.stderr)
        return 2
    node = None
    try:
        _refuse_stray(kind, args)
        with watched(_say_once(kind)):
            node = kind()
        node.get_logger().info(_ready(node))
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        gc.collect()
        gc.freeze()
        try:
            while not stop.asked and not node.finished:
                executor.spin_once(timeout_sec=1.0)
        except BaseException:
            _close_after_failure(node)
            raise
        node.close()
        return node.exit_code
    except (NodeError, BagError, RigError) as error:
        if node is None:
            print(short(f"error: {error}"), file=sys.stderr)
        else:
            node.get_logger().fatal(short(str(error)))
        return 2
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
