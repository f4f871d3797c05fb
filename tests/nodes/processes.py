"""Nodes as processes, and somebody who listens to them."""

import contextlib
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy
from rclpy.serialization import deserialize_message

LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)


def executable(name):
    """Where `ros2 run` looks for it."""
    for prefix in os.environ["AMENT_PREFIX_PATH"].split(os.pathsep):
        path = Path(prefix) / "lib" / "ddh_twin_py" / name
        if path.is_file():
            return str(path)
    raise FileNotFoundError(name)


def wait_for(condition, seconds, what):
    """Wait until `condition()` is true; its value."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if value := condition():
            return value
        time.sleep(0.02)
    raise AssertionError(f"{what}: not within {seconds} s")


class HeldProcess:
    """A process that does not outlive its `with` block; a subclass starts `process` and says what reads its output."""

    process: subprocess.Popen

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()
        self.process.wait()
        self.join_readers()
        self.process.stdout.close()

    def end(self):
        """Kill it if it still runs."""
        if self.process.poll() is None:
            self.process.kill()

    def join_readers(self):
        """Wait for whatever reads its output."""


class NodeProcess(HeldProcess):
    """A node as its own process; `text` is what it has said."""

    def __init__(self, name, namespace="/ddh", **parameters):
        self.name = name
        command = [executable(name), "--ros-args", "-r", f"__ns:={namespace}"]
        for key, value in parameters.items():
            command += ["-p", f"{key.replace('__', '.')}:={_yaml(value)}"]
        self.process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**os.environ, "RCUTILS_COLORIZED_OUTPUT": "0", "PYTHONUNBUFFERED": "1"},
        )
        self.lines = []
        self._reader = threading.Thread(target=lambda: self.lines.extend(iter(self.process.stdout.readline, "")), daemon=True)
        self._reader.start()

    def end(self):
        """Let it leave the graph, or the second try of a failed test would take it for its own for 20 s; then kill it."""
        if self.process.poll() is None:
            self.process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.process.wait(5.0)
        super().end()

    def join_readers(self):
        self._reader.join(5.0)

    @property
    def text(self):
        return "".join(self.lines)

    def says(self, words, seconds=60.0):
        """Wait until a line holds these words."""

        def said():
            found = [line for line in list(self.lines) if words in line]
            assert found or self.process.poll() is None, f"{self.name} ended with {self.process.returncode}:\n{self.text}"
            return found

        return wait_for(said, seconds, f"{self.name} says {words!r}")[0]

    def ends(self, seconds=60.0):
        """Wait for the end; the exit code."""
        try:
            code = self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"{self.name} has not ended within {seconds:g} s:\n{self.text}") from None
        self._reader.join(5.0)
        return code

    def stop(self, number=signal.SIGTERM):
        """Stop it and hold it to a clean end."""
        self.process.send_signal(number)
        code = self.ends(15.0)
        assert code == 0, f"{self.name} ended with {code}:\n{self.text}"
        assert "Traceback" not in self.text, self.text


def _yaml(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_yaml(entry) for entry in value) + "]"
    return repr(value) if isinstance(value, (int, float)) else f"'{value}'"


class Listener:
    """A node of the test's own: collects messages, calls services, looks at the graph."""

    def __init__(self):
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("test_listener", context=self.context)
        self._executor = SingleThreadedExecutor(context=self.context)
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._spin, daemon=True)
        self._going = True
        self._thread.start()

    def _spin(self):
        while self._going:
            self._executor.spin_once(timeout_sec=0.1)

    def here(self, act):
        """The value of `act()`, called by the thread that spins: an answer cannot come before what was asked is noted down."""
        task = self._executor.create_task(act)
        wait_for(task.done, 10.0, "the listener's thread")
        return task.result()

    def close(self):
        self._going = False
        self._thread.join(5.0)
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)

    def collect(self, message_type, topic, reliable=True, latched=False):
        """A list that grows with every message on the topic."""
        found = []
        reliability = QoSReliabilityPolicy.RELIABLE if reliable else QoSReliabilityPolicy.BEST_EFFORT
        profile = LATCHED if latched else QoSProfile(depth=4000, reliability=reliability)
        self.node.create_subscription(
            message_type, topic, lambda data: found.append(deserialize_message(data, message_type)), profile, raw=True
        )
        return found

    def call(self, service_type, name, request, seconds=10.0):
        client = self.node.create_client(service_type, name)
        assert client.wait_for_service(seconds), f"no service {name}"
        future = client.call_async(request)
        wait_for(future.done, seconds, f"answer of {name}")
        self.here(lambda: self.node.destroy_client(client))
        return future.result()

    def withdraw(self, publisher):
        """Destroy a publisher in the thread that spins, which would else wait for a handle that is going."""
        self.here(lambda: self.node.destroy_publisher(publisher))

    def publishers(self, topic):
        return self.node.count_publishers(topic)


def stamp_ns(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def runs(pid):
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def raw_messages(bag, message_type, topic):
    """Messages of one topic of a bag."""
    from ddh_twin_py.sources.raw_bag import RawBag

    raw, found = RawBag(bag), []
    for block in raw.blocks():
        for number, data in zip(block.topic.tolist(), block.messages, strict=True):
            if raw.topics[number][0] == topic:
                found.append(deserialize_message(data, message_type))
    raw.close()
    return found
