"""What a node makes of the telemetry that came while it was busy."""

import time
from types import SimpleNamespace

import pytest
import rclpy
from ddh_twin_py.nodes.feeds import telemetry_feed
from ddh_twin_py.nodes.feeds.telemetry_feed import TelemetryFeed
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.causes import Cause
from nodes.processes import wait_for
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Temperature

pytestmark = pytest.mark.live
TOPICS = ("temperature/ambient", "temperature/motor_winding", "temperature/tank_oil", "temperature/line_a")
EPOCH = 1_772_000_000  # s
SECOND = 1_000_000_000  # ns


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


@pytest.mark.parametrize("busy", [False, True])
def test_what_waited_for_a_process_that_stood_still_is_aligned_in_the_order_of_its_stamps(busy, listener, monkeypatch):
    now = EPOCH * SECOND
    monkeypatch.setattr(telemetry_feed, "time_ns", lambda: now)
    node = rclpy.create_node("still", namespace="/still", context=listener.context)
    feed = TelemetryFeed(node, load_rig(), TOPICS, [], 0.05, 0.5, 1.0)
    ticks = []

    def come(topic, begin, end, at=None):
        """Samples of one topic, two each second; they came at once, or each as it was made."""
        stamps = [EPOCH * SECOND + k * SECOND // 2 for k in range(2 * begin, 2 * end)]
        feed.collect(topic, [at or stamp for stamp in stamps], stamps, [[294.0, 0.0]] * len(stamps))

    def look(topics, begin, end, at=None):
        nonlocal ticks
        feed.take(0.0)
        for topic in topics:
            come(topic, begin, end, at)
        feed.align()
        ticks += feed.ready(10_000)

    for second in range(5):
        now = (EPOCH + second + 1) * SECOND
        look(TOPICS, second, second + 1)
    now = (EPOCH + 25) * SECOND
    look(TOPICS[:2], 5, 25, None if busy else now + SECOND // 1000)
    assert feed.take(0.0) is not busy, "there is some that is not aligned yet"
    if not busy:
        now += SECOND // 10
        look(TOPICS[2:], 5, 25, now)
        assert ticks[-1].end_ns <= (EPOCH + 5) * SECOND
    now += SECOND
    look(TOPICS, 25, 26)
    ticks += feed.flush()
    assert not feed.aligner.strayed and not any(tick.restart for tick in ticks)
    if not busy:
        assert sum(len(tick.samples[topic]) for tick in ticks for topic in TOPICS) == 4 * 52
    node.destroy_node()


def test_a_clock_that_is_set_back_after_a_stand_still_holds_nothing_up(listener, monkeypatch):
    now = EPOCH * SECOND
    monkeypatch.setattr(telemetry_feed, "time_ns", lambda: now)
    node = rclpy.create_node("still", namespace="/set_back", context=listener.context)
    feed = TelemetryFeed(node, load_rig(), TOPICS, [], 0.05, 0.5, 1.0)

    def look():
        feed.take(0.0)
        feed.collect(TOPICS[0], [now], [now], [[294.0, 0.0]])
        feed.align()

    look()
    now += 2 * SECOND  # it stood still
    look()
    assert feed._collected, "what else came meanwhile is awaited"
    now -= 3600 * SECOND
    look()
    assert not feed._collected
    node.destroy_node()


def test_a_reading_that_comes_twice_is_handed_on_once(listener):
    node = rclpy.create_node("twice", namespace="/twice", context=listener.context)
    feed = TelemetryFeed(node, load_rig(), TOPICS, [], 0.05, 0.5, 1.0, keep_late=TOPICS)
    messages = []
    for tenths in (0, 3, 0):
        message = Temperature(temperature=21.0)
        message.header.stamp.sec, message.header.stamp.nanosec = EPOCH, tenths * 100_000_000
        messages.append(serialize_message(message))
    feed._take(feed.inputs.all[TOPICS[0]], feed.screens[TOPICS[0]], messages, [1, 2, 3])
    assert [came for came, *_ in feed._collected] == [1, 2] and feed.screens[TOPICS[0]].count(Cause.REPEATED) == 1
    node.destroy_node()


def test_a_stamp_that_is_none_is_left_out_and_told(listener, monkeypatch):
    said = []
    node = rclpy.create_node("odd", namespace="/odd", context=listener.context)
    monkeypatch.setattr(node, "get_logger", lambda: SimpleNamespace(warning=said.append))
    feed = TelemetryFeed(node, load_rig(), TOPICS[:1], [], 0.05, 0.5, 1.0)
    entry = feed.inputs.all[TOPICS[0]]
    message = Temperature(temperature=21.0)
    message.header.stamp.sec, message.header.stamp.nanosec = EPOCH, 0
    sound = serialize_message(message)
    odd = sound[:8] + (4 * 10**9).to_bytes(4, "little") + sound[12:]
    for _ in range(2):
        feed._take(entry, feed.screens[TOPICS[0]], [odd, sound], [0, 0])
    told = "header.stamp nanosec is 4000000000, allowed are 0 to 999999999"
    assert said == [f"/odd/temperature/ambient: {told}; such are left out and counted"]
    assert entry.rejected == 2 and entry.newest_ns == EPOCH * SECOND
    node.destroy_node()
