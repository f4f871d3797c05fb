"""Qualities of service, and how a subscription adapts to what is published."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.duration import Infinite
from rclpy.qos import QoSCompatibility, QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy, qos_check_compatible
from rclpy.topic_endpoint_info import TopicEndpointInfo

DEPTH = 4000
"""Messages kept for a reader that is busy: 2 s of a stream at 1000 Hz, and as much again."""

SENSOR_DATA = QoSProfile(depth=10, reliability=QoSReliabilityPolicy.BEST_EFFORT)
"""Live telemetry: best effort."""

OUTPUT = QoSProfile(depth=200)
"""What the twin publishes: reliable, 10 s at 20 Hz."""

LATCHED = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""`rig`: whoever comes later still gets it."""

STATUS = QoSProfile(depth=50, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""`gap/status`: whoever comes later gets the last ones."""

DIAGNOSTICS = QoSProfile(depth=10)


def stream(reliable: bool, depth: int = DEPTH) -> QoSProfile:
    """A stream of which nothing may be lost (or best effort), kept for a busy reader."""
    reliability = QoSReliabilityPolicy.RELIABLE if reliable else QoSReliabilityPolicy.BEST_EFFORT
    return QoSProfile(depth=depth, reliability=reliability)


def wants_best_effort(publishers: Sequence[TopicEndpointInfo]) -> bool:
    """Whether some publisher offers best effort alone, so that a reliable subscription would get nothing."""
    return any(p.qos_profile.reliability == QoSReliabilityPolicy.BEST_EFFORT for p in publishers)


def is_latched(publishers: Sequence[TopicEndpointInfo]) -> bool:
    """Whether every publisher keeps its last message for late subscribers."""
    durability = [p.qos_profile.durability for p in publishers]
    return bool(durability) and all(d == QoSDurabilityPolicy.TRANSIENT_LOCAL for d in durability)


def can_match(offered: QoSProfile, asked: QoSProfile) -> bool:
    """Whether a subscription, as the graph tells of it, can get what a publisher of this project offers, which sets no deadline or lease.

    In the graph what is not set is endless, and so it is offered here: the check of ROS takes it for less than that.
    """
    endless = QoSProfile(depth=offered.depth, reliability=offered.reliability, durability=offered.durability, deadline=Infinite,
                         liveliness_lease_duration=Infinite)
    return qos_check_compatible(endless, asked)[0] != QoSCompatibility.ERROR


__all__ = [
    "DEPTH",
    "DIAGNOSTICS",
    "LATCHED",
    "OUTPUT",
    "SENSOR_DATA",
    "STATUS",
    "QoSHistoryPolicy",
    "can_match",
    "is_latched",
    "stream",
    "wants_best_effort",
]
