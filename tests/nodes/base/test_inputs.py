"""What a polled subscription says of messages that cannot be read."""

from types import SimpleNamespace

from ddh_twin_py.nodes.base.inputs import Input, Inputs

from ddh_msgs.msg import HydraulicState


def test_messages_that_are_none_of_the_type_are_counted_and_said_once():
    said = []
    inputs = Inputs(SimpleNamespace(get_logger=lambda: SimpleNamespace(warning=said.append)))
    entry = Input("hydraulics/state", HydraulicState, None, SimpleNamespace(topic_name="/ddh/hydraulics/state"))
    for count in (0, 1, 3):
        inputs.leave_out(entry, count)
    assert entry.rejected == 3 and len(said) == 1 and "/ddh/hydraulics/state: a message is no HydraulicState" in said[0]
