"""What of a bag the player sends, and under which names."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.bags.cdr import encode_stamped_floats
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.qos import SENSOR_DATA
from ddh_twin_py.bags.writer import BagWriter
from ddh_twin_py.nodes.bag_player import BagPlayer, Channel, _relative
from ddh_twin_py.nodes.base.inputs import Input, Inputs
from ddh_twin_py.nodes.base.parameters import NodeError
from ddh_twin_py.nodes.player.flow_control import FlowControl
from ddh_twin_py.sources.raw_bag import RawBag
from rclpy.serialization import serialize_message
from rclpy.validate_topic_name import validate_topic_name

from ddh_msgs.msg import NodeProgress

TOPIC, LISTENER = "/ddh/drive/telemetry", "/ddh/listener"
STAMPS = np.arange(4000) * 10_000_000 + 10**18  # ns, 40 s


class Publisher:
    topic_name = TOPIC

    class qos_profile:
        durability = 0

    def publish(self, message):
        pass


class Player(BagPlayer):
    """A player without a node, of one topic."""

    def __init__(self, bag):
        self._bag, self._flow, self.sent, self._causes = bag, FlowControl(1.0), 0, {}
        self._channels = {0: Channel(Publisher(), True)}

    def warn_once(self, cause, text):
        self._causes.setdefault(cause, text)


def bag_of(path, log_times, messages=None):
    """A bag of drive telemetry with these log times, ns; `messages` by number are others than they should be."""
    rows = encode_stamped_floats(STAMPS, np.zeros((STAMPS.size, 6)))
    with BagWriter(path) as writer:
        for i, at in enumerate(log_times.tolist()):
            writer.write_raw(TOPIC, "ddh_msgs/msg/DriveTelemetry", SENSOR_DATA, at, (messages or {}).get(i, rows[i].data))
    return RawBag(path)


def test_a_message_that_is_too_short_for_a_stamp_is_left_out_and_named(tmp_path):
    player = Player(bag_of(tmp_path / "bag", STAMPS, {500: b"", 600: b"\0\1\0\0\1\0\0"}))
    for block in player._bag.blocks():
        player._send(block)
    assert player.sent == STAMPS.size - 2
    assert list(player._causes.values()) == [f"{tmp_path / 'bag'}: a message on {TOPIC} has 0 bytes and no stamp; such are left out"]


def test_a_message_whose_stamp_is_none_is_left_out_and_named(tmp_path):
    odd = encode_stamped_floats(STAMPS[:1], np.zeros((1, 6)))[0]
    odd[8:12] = np.frombuffer((4 * 10**9).to_bytes(4, "little"), np.uint8)
    player = Player(bag_of(tmp_path / "bag", STAMPS, {500: odd.tobytes(), 600: odd.tobytes()}))
    for block in player._bag.blocks():
        player._send(block)
    assert player.sent == STAMPS.size - 2
    said = f"{TOPIC}: header.stamp nanosec is 4000000000, allowed are 0 to 999999999; such are left out"
    assert list(player._causes.values()) == [f"{tmp_path / 'bag'}: {said}"]


def test_progress_that_is_cut_off_is_left_out(tmp_path):
    player, said = Player(bag_of(tmp_path / "bag", STAMPS)), []
    player._progress = Input("progress", NodeProgress, None, SimpleNamespace(topic_name="/ddh/progress"))
    player._inputs = Inputs(SimpleNamespace(get_logger=lambda: SimpleNamespace(warning=said.append)))
    whole = serialize_message(NodeProgress(node="/ddh/other", topics=[TOPIC], newest=[1], received=[1]))
    player._inputs.take = lambda entry, wall: [whole[:10], whole]
    player._take_progress(0.0)
    assert "/ddh/other" in player._flow.consumers and said == [
        "/ddh/progress: a message is no sound NodeProgress; such are left out and counted"]


def topics_of(topics, namespace=""):
    """What becomes of the topics (name, type) of a bag."""
    player = SimpleNamespace(_bag=SimpleNamespace(path="bag", topics=topics), values={"namespace": namespace})
    return _relative([topic for topic, _ in topics], BagPlayer._namespace(player))


def test_of_two_rigs_in_a_bag_one_is_chosen_and_the_other_keeps_its_name():
    machines = [(f"/rig_{x}/drive/telemetry", "ddh_msgs/msg/DriveTelemetry") for x in "ab"]
    with pytest.raises(BagError, match="holds 2 rigs, in the namespaces '/rig_a' and '/rig_b'; choose one with the parameter namespace"):
        topics_of(machines)
    assert topics_of(machines, "rig_b") == ["/rig_a/drive/telemetry", "drive/telemetry"]
    assert topics_of([*machines[:1], ("/rig_a/other", "std_msgs/msg/Empty"), ("/tf", "std_msgs/msg/Empty")]) == [
        "drive/telemetry", "other", "/tf"]
    assert topics_of([("/tf", "std_msgs/msg/Empty")]) == ["/tf"]


@pytest.mark.parametrize(("chosen", "other"), [("", "/b"), ("/rig", "/rig/b")])
def test_a_rig_whose_namespace_lies_below_the_chosen_one_keeps_its_name(chosen, other):
    machines = [(f"{space}/{name}", kind) for space in (chosen, other) for name, kind in (
        ("drive/telemetry", "ddh_msgs/msg/DriveTelemetry"), ("temperature/tank_oil", "sensor_msgs/msg/Temperature"),
        ("gap/status", "ddh_msgs/msg/GapStatus"))]  # fmt: skip
    own = ["drive/telemetry", "temperature/tank_oil", "gap/status"]
    assert topics_of(machines, chosen or "/") == [*own, *(f"{other}/{name}" for name in own)]


class Channels(BagPlayer):
    """What is needed of a player to make its channels; the names that it publishes are `made`."""

    def __init__(self, *topics):
        self._bag, self.said, self.made = SimpleNamespace(path="bag", topics=topics), [], []
        self.values = {"namespace": "", "topics": ["*"]}

    def get_logger(self):
        return SimpleNamespace(warning=self.said.append)

    def create_publisher(self, kind, name, profile):
        validate_topic_name(name)
        self.made.append(name)


def test_a_topic_with_a_name_that_ros_does_not_allow_is_left_out_and_named():
    player = Channels((TOPIC, "ddh_msgs/msg/DriveTelemetry"), ("/ddh/temp//x y", "sensor_msgs/msg/Temperature"))
    assert list(player._make_channels()) == [0] and player.made == ["drive/telemetry"]
    assert player.said == ["bag: topic /ddh/temp//x y has a name that ROS 2 does not allow; not played"]


def test_a_topic_with_two_types_is_refused_in_a_line():
    player = Channels((TOPIC, "ddh_msgs/msg/DriveTelemetry"), (TOPIC, "sensor_msgs/msg/Temperature"))
    with pytest.raises(NodeError, match=f"bag: topic {TOPIC} has two types, ddh_msgs/msg/DriveTelemetry and sensor_msgs/msg/Temperature"):
        player._make_channels()
