"""What a polled subscription says of messages that cannot be read."""

from types import SimpleNamespace

from ddh_twin_py.nodes.base.inputs import Input, Inputs
from rclpy.serialization import serialize_message

from ddh_msgs.msg import HydraulicState, RigInfo


def test_messages_that_are_none_of_the_type_are_counted_and_said_once():
    said = []
    inputs = Inputs(SimpleNamespace(get_logger=lambda: SimpleNamespace(warning=said.append)))
    entry = Input("hydraulics/state", HydraulicState, None, SimpleNamespace(topic_name="/ddh/hydraulics/state"))
    for count in (0, 1, 3):
        inputs.leave_out(entry, count)
    assert entry.rejected == 3 and len(said) == 1 and "/ddh/hydraulics/state: a message is no sound HydraulicState" in said[0]


def test_a_message_that_is_cut_off_is_left_out():
    said = []
    inputs = Inputs(SimpleNamespace(get_logger=lambda: SimpleNamespace(warning=said.append)))
    entry = Input("rig", RigInfo, None, SimpleNamespace(topic_name="/ddh/rig"))
    whole = serialize_message(RigInfo(rig_id="x"))
    assert [message.rig_id for message in inputs.read(entry, [whole[:10], whole, b"\0\1\0\0", b"", whole])] == ["x", "x"]
    inputs.read(entry, [whole[:10]])
    assert entry.rejected == 4 and len(said) == 1 and "/ddh/rig: a message is no sound RigInfo" in said[0]
