"""What a node makes of the telemetry that came while it was busy."""

import time

import pytest
import rclpy
from ddh_twin_py.nodes.telemetry_feed import TelemetryFeed
from ddh_twin_py.rig import load_rig
from nodes.processes import wait_for
from sensor_msgs.msg import Temperature

pytestmark = pytest.mark.live
TOPICS = ("temperature/ambient", "temperature/motor_winding", "temperature/tank_oil", "temperature/line_a")
EPOCH = 1_772_000_000  # s


def test_what_came_while_a_node_was_busy_is_aligned_in_the_order_in_which_it_came(listener):
    node = rclpy.create_node("busy", namespace="/busy", context=listener.context)
    feed = TelemetryFeed(node, load_rig(), TOPICS, [], 0.05, 0.5, 1.0)
    made = [listener.node.create_publisher(Temperature, f"/busy/{topic}", 200) for topic in TOPICS]
    wait_for(lambda: all(publisher.get_subscription_count() for publisher in made), 30.0, "subscriptions")
    for half_seconds in range(60):
        for publisher in made:
            message = Temperature(temperature=21.0 + 0.01 * (half_seconds % 7))
            ahead = 7_200 if 20 <= half_seconds < 40 else 0  # the clock is wrong for 10 s
            message.header.stamp.sec, message.header.stamp.nanosec = EPOCH + half_seconds // 2 + ahead, half_seconds % 2 * 500_000_000
            publisher.publish(message)
        time.sleep(0.005)
    time.sleep(0.5)
    assert feed.take(0.0) and not feed.take(0.0)
    feed.align()
    ticks = feed.ready(7) + feed.ready(10_000) + feed.flush()
    assert sum(count for (_, cause), count in feed.aligner.counts.items() if cause == "clock_jump") == 1
    assert [tick.end_ns * 1e-9 - EPOCH for tick in ticks if tick.restart] == pytest.approx([7_210.0, 20.0])
    assert len(ticks) < 3 * 200 and sum(len(tick.samples[topic]) for tick in ticks for topic in TOPICS) > 220
    for publisher in made:
        listener.withdraw(publisher)
    node.destroy_node()
