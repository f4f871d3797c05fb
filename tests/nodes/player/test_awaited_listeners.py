"""Playing begins once all that must listen do, or nobody must and none came."""

from types import SimpleNamespace

import pytest
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.parameters import NodeError
from ddh_twin_py.nodes.player.awaited_listeners import AwaitedListeners
from rclpy.duration import Infinite
from rclpy.qos import QoSDurabilityPolicy, QoSProfile, QoSReliabilityPolicy

TOPIC, FUSION = "/rig/drive/telemetry", "/rig/temperature_fusion"


def discovered(**asked):
    """What is asked for, as the graph tells it: what is not set is endless."""
    return QoSProfile(depth=10, deadline=Infinite, liveliness_lease_duration=Infinite, **asked)


class Graph:
    """A graph in which one topic is played and nodes come to listen to it."""

    def __init__(self):
        self.said, self.subscribed, self.matched, self.nodes = [], {}, True, []
        self.flow = SimpleNamespace(consumers={})

    def get_namespace(self):
        return "/rig"

    def get_logger(self):
        return SimpleNamespace(info=self.said.append)

    def get_node_names_and_namespaces(self):
        return [(name.rsplit("/", 1)[1], name.rsplit("/", 1)[0]) for name in self.nodes]

    def get_subscriptions_info_by_topic(self, topic):
        return [SimpleNamespace(node_namespace=name.rsplit("/", 1)[0], node_name=name.rsplit("/", 1)[1], qos_profile=profile)
                for name, profile in self.subscribed.items()]

    def listens(self, name, reliability=qos.OUTPUT.reliability):
        self.subscribed[name] = discovered(reliability=reliability)
        self.nodes.append(name)
        self.flow.consumers[name] = SimpleNamespace(topics={TOPIC: None})

    def matches(self):
        asks_for_more = QoSDurabilityPolicy.TRANSIENT_LOCAL  # than the player offers
        return sum(p.durability != asks_for_more for p in self.subscribed.values()) if self.matched else 0

    def awaited(self, *named, wait=5.0):
        publisher = SimpleNamespace(topic_name=TOPIC, qos_profile=qos.stream(reliable=True), get_subscription_count=self.matches)
        return AwaitedListeners(self, self.flow, [publisher], named, wait, begun=0.0)


@pytest.fixture
def graph():
    return Graph()


@pytest.mark.parametrize("named", [(), ("temperature_fusion",), (FUSION,), ("",)])
def test_it_begins_a_moment_after_the_last_match(graph, named):
    awaited = graph.awaited(*named)
    assert not awaited.are_there(1.0)
    graph.listens(FUSION)
    assert not awaited.are_there(1.1) and not awaited.are_there(1.3) and awaited.are_there(1.5)


def test_who_is_gone_again_meanwhile_is_waited_for_anew(graph):
    awaited = graph.awaited("temperature_fusion")
    graph.listens(FUSION)
    assert not awaited.are_there(1.0)
    graph.matched = False
    assert not awaited.are_there(1.2)
    graph.matched = True
    assert not awaited.are_there(2.0) and awaited.are_there(2.4)


def test_where_nobody_must_listen_it_plays_all_the_same(graph):
    awaited = graph.awaited()
    assert not awaited.are_there(4.9) and awaited.are_there(5.1)
    assert any("nobody listens after 5 s" in said for said in graph.said)


@pytest.mark.parametrize("named", [(), ("temperature_fusion",)])
def test_a_bystander_that_can_never_be_matched_hides_no_listener(graph, named):
    awaited = graph.awaited(*named)
    graph.subscribed["/rig/plotter"] = discovered(durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
    assert not awaited.are_there(1.0)
    graph.listens(FUSION)
    assert not awaited.are_there(2.0) and awaited.are_there(2.4) and not graph.said


def test_where_nobody_must_listen_one_that_would_lose_messages_is_not_called_nobody(graph):
    awaited = graph.awaited()
    graph.listens(FUSION, QoSReliabilityPolicy.BEST_EFFORT)
    assert not awaited.are_there(4.9) and awaited.are_there(5.1)
    assert graph.said == [f"there is no node {FUSION} to listen reliably to {TOPIC} after 5 s, playing all the same"]


def test_a_node_that_is_not_there_is_an_error_after_a_minute(graph):
    awaited = graph.awaited("temperature_fusion")
    assert not awaited.are_there(64.9)
    with pytest.raises(NodeError, match=f"waited 65 s for node {FUSION}; is it running, in namespace /rig"):
        awaited.are_there(65.1)


def test_a_node_that_is_there_and_compiles_has_longer_and_is_told_of_once(graph):
    awaited = graph.awaited("temperature_fusion")
    graph.nodes.append(FUSION)
    assert not any(awaited.are_there(wall) for wall in (1.0, 6.0, 66.0, 900.0))
    assert len(graph.said) == 1 and "compiles the model" in graph.said[0]
    with pytest.raises(NodeError, match="waited 906 s"):
        awaited.are_there(906.0)


def test_one_that_would_lose_messages_is_not_enough(graph):
    awaited = graph.awaited("temperature_fusion")
    graph.listens(FUSION, QoSReliabilityPolicy.BEST_EFFORT)
    with pytest.raises(NodeError, match=f"to listen reliably to {TOPIC}"):
        awaited.are_there(66.0)


def test_a_long_wait_does_not_end_as_the_node_becomes_ready(graph):
    awaited = graph.awaited("temperature_fusion")
    graph.nodes.append(FUSION)
    assert not awaited.are_there(1.0) and not awaited.are_there(300.0)
    graph.listens(FUSION)
    graph.matched = False
    assert not awaited.are_there(300.05) and not awaited.are_there(360.0)
    graph.matched = True
    assert not awaited.are_there(360.03)  # it settles
    graph.matched = False
    assert not awaited.are_there(360.1) and not awaited.are_there(420.0)
    with pytest.raises(NodeError, match=f"waited 420 s for node {FUSION} to listen reliably"):
        awaited.are_there(420.2)


def test_a_long_wait_does_not_end_as_one_of_several_leaves_the_graph_for_a_moment(graph):
    awaited, model = graph.awaited("temperature_fusion", "hydraulic_model"), "/rig/hydraulic_model"
    graph.nodes += [FUSION, model]
    assert not awaited.are_there(100.0)
    graph.nodes.remove(model)
    assert not awaited.are_there(100.05)
    graph.nodes.append(model)
    assert not any(awaited.are_there(wall) for wall in (100.1, 200.0, 900.0))
    graph.nodes.remove(model)
    assert not awaited.are_there(901.0)
    with pytest.raises(NodeError, match=f"waited 961 s for node {model}"):
        awaited.are_there(961.0)


def test_who_comes_and_goes_is_not_waited_for_without_end(graph):
    awaited = graph.awaited("temperature_fusion")
    with pytest.raises(NodeError, match="waited 965 s"):
        for wall in range(0, 2000, 5):
            graph.nodes = [] if graph.nodes else [FUSION]
            awaited.are_there(float(wall))
