"""A parameter file for the nodes of the twin, looked at before one of them is started: each would find another fault, or none."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

from ddh_twin_py.names import no_such
from ddh_twin_py.nodes.bag_player import BagPlayer
from ddh_twin_py.nodes.bag_recorder import BagRecorder
from ddh_twin_py.nodes.gap_monitor import GapMonitorNode
from ddh_twin_py.nodes.hydraulic_model import HydraulicModelNode
from ddh_twin_py.nodes.model_node import MODEL_PARAMETERS
from ddh_twin_py.nodes.parameters import Parameter
from ddh_twin_py.nodes.telemetry_publisher import parameters as telemetry_parameters
from ddh_twin_py.nodes.temperature_fusion import TemperatureFusionNode
from ddh_twin_py.nodes.web_view import WebView
from ddh_twin_py.rig.yaml_file import read_yaml

PARAMETERS: dict[str, tuple[Parameter, ...]] = {
    "hydraulic_model": (*HydraulicModelNode.PARAMETERS, *MODEL_PARAMETERS),
    "machine_thermal": MODEL_PARAMETERS,
    "temperature_fusion": TemperatureFusionNode.PARAMETERS,
    "gap_monitor": GapMonitorNode.PARAMETERS,
    "drive_telemetry": telemetry_parameters(),
    "pressure_telemetry": telemetry_parameters(),
    "bag_player": BagPlayer.PARAMETERS,
    "bag_recorder": BagRecorder.PARAMETERS,
    "web_view": WebView.PARAMETERS,
}
"""What each node declares."""

_SECTION = "ros__parameters"
_ANY_NODE = ("*", "**")
_OF_ROS = (
    Parameter("use_sim_time", False, "Time is that of /clock."),
    Parameter("start_type_description_service", True, "Tell the definitions of message types."),
)
_FREE = "qos_overrides."  # of ROS, too: by topic and policy


class ParameterFileError(ValueError):
    """A parameter file that nodes cannot use; the message is one line that names file, key and value."""


def check_parameter_file(path: str | Path) -> None:
    """Refuse a file that some node would refuse, or that names a node or a parameter that there is not.

    Raises ParameterFileError.
    """
    content = read_yaml(path, "parameter file", ParameterFileError)
    for node, given in _sections(content, str(path), ""):
        kinds = PARAMETERS if node.rpartition("/")[2] in _ANY_NODE else {node: PARAMETERS[node.rpartition("/")[2]]}
        for name, value in _flat(given, ""):
            _check_value(f"{path}: {node}: ", name, value, [p for kind in kinds.values() for p in (*kind, *_OF_ROS)])


def unanswered(path: str | Path, namespace: str) -> list[str]:
    """Sections of a file that was checked of which no node of a namespace takes anything, as ROS matches their names."""
    content = read_yaml(path, "parameter file", ParameterFileError)
    nodes = [f"{namespace.rstrip('/')}/{node}" for node in PARAMETERS]

    def answers(section: str) -> bool:
        levels = [{"**": ".*", "*": "[^/]+"}.get(level, re.escape(level)) for level in section.strip("/").split("/")]
        pattern = re.compile("/" + "/".join(levels).replace(".*/", "(?:.*/)?"))
        return any(pattern.fullmatch(node) for node in nodes)

    return [section for section, _ in _sections(content, str(path), "") if not answers(section)]


def _sections(content: object, file: str, path: str) -> Iterator[tuple[str, Mapping]]:
    """Nodes as they are named, and what is given to each."""
    if not isinstance(content, Mapping):
        where = f"{path}: " if path else ""
        raise ParameterFileError(f"{file}: {where}holds {content!r}, a node's name with {_SECTION} is needed")
    name = path.rpartition("/")[2]
    for key, value in content.items():
        if key == _SECTION:
            if not path:
                raise ParameterFileError(f"{file}: {_SECTION} stands below no node; valid are {', '.join((*PARAMETERS, *_ANY_NODE))}")
            if name not in _ANY_NODE and name not in PARAMETERS:
                raise ParameterFileError(f"{file}: {path}: {no_such('node', name, PARAMETERS)}")
            if not isinstance(value, Mapping):
                raise ParameterFileError(f"{file}: {path}: {_SECTION} is {value!r}, parameters with values are needed")
            yield path, value
        elif name in PARAMETERS or name in _ANY_NODE and not isinstance(value, Mapping):
            raise ParameterFileError(f"{file}: {path}: no section {key!r}; the only one is {_SECTION!r}")
        else:
            yield from _sections(value, file, f"{path}/{key}" if path else str(key))


def _flat(given: Mapping, before: str) -> Iterator[tuple[str, object]]:
    """Parameters by their dotted names."""
    for key, value in given.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value


def _check_value(where: str, name: str, value: object, declared: list[Parameter]) -> None:
    if name.startswith(_FREE):
        return
    of_name = [parameter for parameter in declared if parameter.name == name]
    if not of_name:
        raise ParameterFileError(f"{where}{no_such('parameter', name, dict.fromkeys(p.name for p in declared))}")
    for parameter in of_name:
        if not parameter.takes(value):
            raise ParameterFileError(f"{where}{name} is {value!r}, {parameter.must_be(value)}")
