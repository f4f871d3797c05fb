"""Parameters of `diagnostic_aggregator`: `/diagnostics` as a tree by component, for rqt_robot_monitor."""

from __future__ import annotations

import yaml

from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC, TEMPERATURE_PREFIX, TEMPERATURE_SENSORS

_GENERIC, _GROUP = "diagnostic_aggregator/GenericAnalyzer", "diagnostic_aggregator/AnalyzerGroup"
_NODES = ("hydraulic_model", "machine_thermal", "temperature_fusion", "gap_monitor", "drive_telemetry", "pressure_telemetry", "bag_player",
          "bag_recorder", "web_view")
_LISTENERS = ("hydraulic_model", "machine_thermal", "temperature_fusion")
"""Nodes that judge the machine's streams."""


def analyzers(namespace: str) -> dict:
    """The tree: what is measured by component, limits, gap, and all that each node of the twin says.

    Args:
        namespace: of the twin, with a leading slash, '' for the root.
    """
    space = namespace.strip("/")

    def said(nodes: tuple[str, ...], concern: str) -> list[str]:
        return [f"{space}/{node}: {concern}" if space else f"{node}: {concern}" for node in nodes]

    machine = {
        "drive": _one("Drive", said(_LISTENERS, DRIVE_TOPIC)),
        "hydraulics": _one("Hydraulics", said(_LISTENERS, HYDRAULIC_TOPIC)),
        **{f"temperature_{sensor}": _one(f"Temperature {sensor.replace('_', ' ')}", said(_LISTENERS, TEMPERATURE_PREFIX + sensor))
           for sensor in TEMPERATURE_SENSORS},
    }
    twin = {node: _one(node.replace("_", " ").capitalize(), said((node,), "")) for node in _NODES}
    return {"analyzers": {"ros__parameters": {
        "path": f"DDH {space}" if space else "DDH",
        "machine": {"type": _GROUP, "path": "Machine", "analyzers": machine},
        "limits": _one("Limits", said(("temperature_fusion",), "limits")),
        "gap": _one("Gap", said(("gap_monitor",), "gap")),
        "twin": {"type": _GROUP, "path": "Twin", "analyzers": twin},
    }}}


def _one(path: str, begins: list[str]) -> dict:
    return {"type": _GENERIC, "path": path, "startswith": begins}


def aggregator_yaml(namespace: str) -> str:
    """The parameter file."""
    head = (
        "# /diagnostics of the twin as a tree by component, for rqt_robot_monitor:\n#\n"
        "#   ros2 run diagnostic_aggregator aggregator_node --ros-args --params-file diagnostic_aggregator.yaml\n"
        "#   ros2 run rqt_robot_monitor rqt_robot_monitor\n"
    )
    return head + yaml.safe_dump(analyzers(namespace), sort_keys=False, width=140)
