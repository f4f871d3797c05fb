"""What the live page takes of messages that are not sound."""

import pytest
from ddh_twin_py.nodes.feeds.page_inputs import page_rows
from rclpy.serialization import serialize_message

from ddh_msgs.msg import HydraulicState, MotorThermalState


@pytest.mark.parametrize(("topic", "unsound"), [
    ("hydraulics/state", HydraulicState(mode="soft_sensor", heat_nodes=["housing"])),
    ("hydraulics/prediction", HydraulicState(mode="free_run", temperature_nodes=["housing"])),
    ("motor/thermal_state", MotorThermalState(nodes=["end_winding"])),
])  # fmt: skip
def test_a_message_without_a_value_for_each_name_is_left_out_and_counted(topic, unsound):
    rows = page_rows()[topic]
    sound = serialize_message(type(unsound)())
    assert len(list(rows.parse([serialize_message(unsound), sound]))) == 1 and rows.unreadable == 1
