"""The player waits for what listeners have not reported, and for nothing else."""

import pytest
from ddh_twin_py.nodes.player.flow_control import FlowControl

S = 1_000_000_000
TOPIC = "/ddh/drive/telemetry"


def sent(flow, *seconds, topic=TOPIC):
    for second in seconds:
        flow.sent(topic, round(second * S), round(second * S))


def flow_with(*names, topics=(TOPIC,)):
    flow = FlowControl(lead=1.0)
    for name in names:
        flow.report(name, dict.fromkeys(topics, 0), 0.0)
    return flow


def test_nobody_known_is_nobody_waited_for():
    flow = FlowControl(lead=1.0)
    sent(flow, 1.0, 2.0)
    assert flow.limit() is None


def test_the_slowest_sets_the_limit():
    flow = flow_with("fast", "slow")
    sent(flow, 1.0, 1.5, 2.0)
    flow.report("fast", {TOPIC: 2 * S}, 0.0)
    assert flow.slowest().name == "slow"
    assert flow.limit() == 2 * S
    flow.report("slow", {TOPIC: round(1.5 * S)}, 0.0)
    assert flow.limit() == 3 * S
    flow.report("slow", {TOPIC: 2 * S}, 0.0)
    assert flow.limit() is None


def test_each_topic_counts_for_itself():
    flow = flow_with("node", topics=("a", "b"))
    sent(flow, 1.0, topic="a")
    sent(flow, 1.2, topic="b")
    flow.report("node", {"a": S, "b": 0}, 0.0)
    assert flow.limit() == round(2.2 * S)


def test_a_rare_topic_does_not_stall():
    flow = flow_with("node", topics=("a", "rare"))
    sent(flow, 1.0, topic="rare")
    flow.report("node", {"a": 0, "rare": S}, 0.0)
    assert flow.limit() is None  # nothing outstanding, however long ago the last one was


def test_a_topic_that_a_node_does_not_take_is_not_waited_for():
    flow = flow_with("node")
    sent(flow, 1.0, topic="other")
    assert flow.limit() is None


def test_late_stragglers_do_not_hold_up():
    flow = flow_with("node")
    sent(flow, 1.0, 1.3, 1.1)
    flow.report("node", {TOPIC: round(1.3 * S)}, 0.0)
    assert flow.limit() is None


def test_after_a_jump_back_old_reports_do_not_count():
    flow = flow_with("node")
    sent(flow, 100.0)
    flow.report("node", {TOPIC: 100 * S}, 0.0)
    flow.jumped()
    sent(flow, 0.0, 0.1)
    flow.report("node", {TOPIC: 100 * S}, 0.0)  # still on its way from before
    assert flow.limit() == S
    flow.report("node", {TOPIC: round(0.1 * S)}, 0.0)
    assert flow.limit() is None


def test_stamps_that_jump_in_the_bag_itself_do_not_stall():
    flow = flow_with("node")
    sent(flow, 50.0, 5.0, 5.1)
    flow.report("node", {TOPIC: round(5.1 * S)}, 0.0)
    assert flow.limit() is None


def test_a_node_that_died_is_not_called_slow():
    flow = flow_with("node")
    sent(flow, 1.0, 2.0)
    flow.report("node", {TOPIC: S}, 5.0)
    assert flow.held_by(6.4, 2.0) == ("slow", "node cannot take 2 times real time; playing as fast as it can")
    assert flow.held_by(6.6, 2.0) == ("gone", "node has said nothing for 1.5 s, it died or hangs; waiting for it up to 4 s")


def test_a_silent_node_is_given_up():
    flow = flow_with("gone")
    sent(flow, 1.0)
    assert flow.given_up(3.0) == []
    (said,) = flow.given_up(8.0)
    assert "gone has said nothing" in said
    assert flow.limit() is None


def test_a_node_that_lost_messages_is_not_waited_for_for_ever():
    flow = flow_with("lossy")
    sent(flow, 1.0)
    for second in range(14):
        flow.report("lossy", {TOPIC: 0}, float(second))
        said = flow.given_up(float(second))
    assert flow.limit() is None
    sent(flow, 2.0)
    assert flow.limit() == 3 * S  # and counts again afterwards
    assert isinstance(said, list)


def test_a_node_started_anew_owes_nothing_of_its_predecessor():
    flow = flow_with()
    flow.report("node", {TOPIC: 0}, 0.0, received=50)
    sent(flow, 1.0)
    flow.report("node", {TOPIC: 0}, 0.1, received=0)
    assert flow.limit() is None


@pytest.mark.parametrize("predecessor", [True, False])
def test_a_node_that_comes_while_messages_are_sent_owes_none_before_the_first_that_it_got(predecessor):
    flow = flow_with()
    if predecessor:
        flow.report("node", {TOPIC: 0}, 0.0, received=50)
    sent(flow, 1.0)
    flow.report("node", {TOPIC: 0}, 0.1, received=0)
    sent(flow, 1.1, 1.2)  # its subscription is not matched yet
    assert flow.limit() is None
    flow.report("node", {TOPIC: round(1.3 * S)}, 0.2, received=1)
    sent(flow, 1.4)
    assert flow.limit() == round(2.4 * S)


def test_a_node_that_was_stopped_is_forgotten():
    flow = flow_with("stays", "stopped")
    sent(flow, 1.0)
    flow.keep(["stays", "other"])
    assert list(flow.consumers) == ["stays"]
