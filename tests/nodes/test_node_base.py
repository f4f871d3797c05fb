"""What every node answers without ROS."""

import pytest
from ddh_twin_py.nodes.drive_telemetry import DriveTelemetryNode
from ddh_twin_py.nodes.gap_monitor import GapMonitorNode
from ddh_twin_py.nodes.node_base import run


@pytest.mark.parametrize("node, parameter", [(GapMonitorNode, "false_alarm_hours"), (DriveTelemetryNode, "")])
@pytest.mark.parametrize("asked", ["--help", "-h"])
def test_help_is_told_and_no_node_starts(node, parameter, asked, capsys):
    assert run(node, [asked]) == 0
    told = capsys.readouterr().out
    assert told.startswith("Node: ") and "usage: ros2 run ddh_twin_py" in told and parameter in told
