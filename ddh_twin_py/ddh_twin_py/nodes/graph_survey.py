"""Listens to a ROS 2 graph for a while: who is there, what comes how often."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Header

from ddh_twin_py.bags.topics import split_topic
from ddh_twin_py.doctor.survey import Health, HeardTopic, Survey
from ddh_twin_py.doctor.twin import OUTPUTS
from ddh_twin_py.names import in_namespace
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.inputs import Inputs
from ddh_twin_py.nodes.messages.message_classes import message_class

_POLL = 0.005  # s
_LOOK = 0.25  # s between two looks for new topics
_LOOP_WAIT = 10.0  # s
_ENVIRONMENT = ("ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "FASTRTPS_DEFAULT_PROFILES_FILE", "RMW_IMPLEMENTATION")
_SPEAK = """\
import sys, time, rclpy
from std_msgs.msg import Header
rclpy.init()
node = rclpy.create_node("ddh_doctor_voice_%d" % __import__("os").getpid())
publisher = node.create_publisher(Header, sys.argv[1], 10)
end = time.monotonic() + float(sys.argv[2])
while time.monotonic() < end:
    publisher.publish(Header(frame_id="doctor"))
    time.sleep(0.05)
"""


def survey(seconds: float, progress: Callable[[float], None] | None = None) -> Survey:
    """Listen for so many seconds of wall time, after a message of a process of our own has come or ten seconds are over.

    Raises RuntimeError where the middleware cannot be started.
    """
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = rclpy.create_node(f"ddh_doctor_{os.getpid()}", enable_rosout=False, start_parameter_services=False)
        try:
            loop = _own_loop(node)
            return _listen(node, seconds, loop, progress)
        finally:
            node.destroy_node()
    finally:
        rclpy.try_shutdown()


def _own_loop(node: Node) -> float | None:
    """s from the start of a process to its first message here, None where none came."""
    topic = f"/ddh_doctor_{os.getpid()}"
    inputs = Inputs(node)
    entry = inputs.add(topic, Header, qos.DIAGNOSTICS)
    started = time.monotonic()
    voice = subprocess.Popen([sys.executable, "-c", _SPEAK, topic, str(_LOOP_WAIT)], stdin=subprocess.DEVNULL,
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        while (took := time.monotonic() - started) < _LOOP_WAIT:
            if inputs.take(entry, took):
                return took
            time.sleep(_POLL)
        return None
    finally:
        voice.kill()
        voice.wait()
        node.destroy_subscription(entry.subscription)


def _listen(node: Node, seconds: float, loop: float | None, progress: Callable[[float], None] | None) -> Survey:
    inputs = Inputs(node)
    health = inputs.add("/diagnostics", DiagnosticArray, qos.DIAGNOSTICS)
    arrived: dict[str, list[int]] = {}
    messages: dict[str, list[bytes]] = {}
    statuses: dict[str, Health] = {}
    started, looked = time.monotonic(), -_LOOK
    while (now := time.monotonic() - started) < seconds:
        if now - looked >= _LOOK:
            looked = now
            _look(node, inputs)
            if progress is not None:
                progress(now / seconds)
        for name, entry in inputs.all.items():
            taken = inputs.take(entry, now)
            if entry is health:
                for message in inputs.read(health, taken):
                    for status in message.status:
                        statuses[status.name] = Health(status.name, int.from_bytes(status.level, "little"), status.message)
            elif taken:
                arrived.setdefault(name, []).extend([time.time_ns()] * len(taken))
                messages.setdefault(name, []).extend(taken)
        time.sleep(_POLL)
    topics, others = {}, []
    for name, types in node.get_topic_names_and_types():
        if not _wanted(name):
            others.append(name)
            continue
        publishers = node.get_publishers_info_by_topic(name)
        topics[name] = HeardTopic(
            name, tuple(types), tuple(in_namespace(p.node_namespace, p.node_name) for p in publishers),
            qos.wants_best_effort(publishers), qos.is_latched(publishers),
            np.array(arrived.get(name, []), np.int64), messages.get(name, []),
        )
    return Survey(
        seconds, int(os.environ.get("ROS_DOMAIN_ID") or 0), rclpy.get_rmw_implementation_identifier(),
        tuple(in_namespace(namespace, name) for name, namespace in node.get_node_names_and_namespaces() if name != node.get_name()),
        topics, tuple(others), tuple(statuses.values()), node.count_publishers("/clock") > 0, loop,
        {name: os.environ.get(name, "") for name in _ENVIRONMENT},
    )


def _wanted(topic: str) -> bool:
    return split_topic(topic) is not None or any(topic.endswith(f"/{name}") for name in OUTPUTS)


def _look(node: Node, inputs: Inputs) -> None:
    """Subscribe to what has appeared."""
    for name, types in node.get_topic_names_and_types():
        if name in inputs.all or not _wanted(name) or len(types) != 1:
            continue
        publishers, kind = node.get_publishers_info_by_topic(name), message_class(types[0])
        if publishers and kind is not None:
            inputs.add(name, kind, qos.LATCHED if qos.is_latched(publishers) else None,
                       reliable=not qos.wants_best_effort(publishers))
    inputs.adapt()
