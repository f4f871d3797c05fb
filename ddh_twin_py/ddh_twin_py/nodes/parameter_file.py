"""A parameter file for the nodes of the twin, looked at before one of them is started: each would find another fault, or none."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import yaml

from ddh_twin_py.names import cited, in_namespace, nearest, no_such
from ddh_twin_py.nodes.bag_player import BagPlayer
from ddh_twin_py.nodes.bag_recorder import BagRecorder
from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.nodes.gap_monitor import GapMonitorNode
from ddh_twin_py.nodes.hydraulic_model import HydraulicModelNode
from ddh_twin_py.nodes.model_node import MODEL_PARAMETERS
from ddh_twin_py.nodes.telemetry_publisher import parameters as telemetry_parameters
from ddh_twin_py.nodes.temperature_fusion import TemperatureFusionNode
from ddh_twin_py.nodes.web_view import WebView
from ddh_twin_py.rig import RigError, load_rig
from ddh_twin_py.rig.files import no_regular_file
from ddh_twin_py.rig.unique_keys import Loader
from ddh_twin_py.rig.yaml_file import mapping, read_yaml, shown

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
_READ = ("rig", "simulation.rig")
"""Parameters that name a rig file."""
_KEPT = ("state_file", "normal_file")
"""Parameters that name a file which a node writes, and reads where it is there."""
_FREE = "qos_overrides."  # of ROS, too: by topic and policy


class ParameterFileError(ValueError):
    """A parameter file that nodes cannot use; the message is one line that names file, key and value."""


class AsRos(Loader):
    """Reads a value as ROS does: 1e3 is a number without quotes and text with them, 1_000 and 1:30 are text, and there are no aliases."""

    yaml_implicit_resolvers: dict = {}
    bool_values = {**Loader.bool_values, "y": True, "n": False}

    def compose_node(self, parent: yaml.Node, index: object) -> yaml.Node:
        """See `yaml.SafeLoader`."""
        if self.check_event(yaml.AliasEvent):
            raise yaml.composer.ComposerError(None, None, "an alias, which ROS does not take", self.peek_event().start_mark)
        return super().compose_node(parent, index)


for _kind, _pattern in (
    ("null", r"~|null|Null|NULL|"),
    ("bool", r"[yY]|yes|Yes|YES|[nN]|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF"),
    ("int", r"[-+]?(?:0x[0-9a-fA-F]+|0[0-7]*|[1-9][0-9]{0,17})"),  # longer ones are double
    ("float", r"[-+]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|\.?(?:inf|Inf|INF))|\.?(?:nan|NaN|NAN)"),
):
    AsRos.add_implicit_resolver(f"tag:yaml.org,2002:{_kind}", re.compile(rf"(?:{_pattern})\Z"), None)


def read_parameter_file(path: str | Path) -> dict[str, dict[str, object]]:
    """Sections of a file, a node's name with what it is given by dotted names; `check_values` holds them against what nodes declare.

    Raises:
        ParameterFileError: ROS would not read it, so that no node would start with it, whichever it is written for.
    """
    content = mapping(read_yaml(path, "parameter file", ParameterFileError, AsRos), str(path), "parameter file", ParameterFileError,
                      f"nodes with {_SECTION}")
    sections: dict[str, dict[str, object]] = {}
    for node, given in _sections(content, str(path), ""):
        values = sections.setdefault(node, {})
        for name, value in _flat(given, ""):
            if value is None or isinstance(value, list) and (None in value or len({type(entry) for entry in value}) > 1):
                raise ParameterFileError(f"{path}: {node}: {name} is {shown(value)}, {_must_be(node, name, value)}")
            values[name] = value
    return sections


def _must_be(section: str, name: str, value: object) -> str:
    """What is asked of a value that ROS does not read."""
    kinds = PARAMETERS.values() if _last(section) in _ANY_NODE else [PARAMETERS.get(_last(section), ())]
    declared = next((p for kind in kinds for p in kind if p.name == name), None)
    return declared.must_be(value) if declared else "a value, or a list of values of one type, is needed"


def of_other_nodes(sections: Iterable[str]) -> dict[str, str]:
    """Sections that name a node which is none of the twin's, and that in words: one file may hold what all nodes of a robot are given."""
    named = {section: _last(section) for section in sections}
    return {section: f"no node {cited(name)} is the twin's{nearest(name, PARAMETERS)}" for section, name in named.items()
            if name not in PARAMETERS and name not in _ANY_NODE}


def check_values(path: str | Path, sections: Mapping[str, Mapping[str, object]], namespace: str, started: Iterable[str]) -> list[str]:
    """Hold sections against what nodes declare.

    Args:
        path: of the parameter file. sections: what it holds for nodes of the twin, see `of_other_nodes`. namespace: of the nodes.
        started: the nodes that are to be started.

    Returns:
        What is wrong with what only nodes would take that are not started, or are in another namespace.

    Raises:
        ParameterFileError: a node that is started would refuse it, or it names a parameter that there is not.
    """
    said: list[str] = []
    for section, values in sections.items():
        last = _last(section)
        near = [node for node in started if _takes(section, in_namespace(namespace, node))]
        kinds = PARAMETERS if last in _ANY_NODE else {last: PARAMETERS[last]}
        for name, value in values.items():
            of_started = [node for node in near if any(p.name == name for p in (*PARAMETERS[node], *_OF_ROS))]
            known = any(p.name == name for kind in kinds.values() for p in (*kind, *_OF_ROS))
            declared = [p for node in of_started or kinds for p in (*PARAMETERS[node], *_OF_ROS)]
            if fault := _fault(name, value, declared):
                _tell(f"{path}: {section}: {fault}", bool(of_started if known else near), said)
    return said


def _tell(fault: str, concerns: bool, said: list[str]) -> None:
    """Raise what concerns a node that is started, keep what does not."""
    if concerns:
        raise ParameterFileError(fault)
    said.append(fault)


def _last(section: str) -> str:
    return section.rpartition("/")[2]


def check_files(path: str | Path, sections: Mapping[str, Mapping[str, object]], namespace: str,
                started: Mapping[str, Mapping[str, object]]) -> None:
    """Refuse a file that is named for a node that is to be started, and that the node could not use.

    Args:
        path: of the parameter file. sections: what it holds. namespace: of the nodes. started: nodes, and what each is given elsewhere,
            which comes before the file.

    Raises:
        ParameterFileError: there is no such rig file, it cannot be read, or a file to be kept is no regular one.
    """
    for section, values in sections.items():
        declared = {p.name for node, own in started.items() if _takes(section, in_namespace(namespace, node))
                    for p in PARAMETERS[node] if p.name not in own}
        for name in declared.intersection(values, (*_READ, *_KEPT)):
            file = str(values[name])
            try:
                if file and name in _READ:
                    load_rig(file)
                elif file and name in _KEPT and Path(file).exists() and (what := no_regular_file(file)):
                    raise RigError(f"{file} is {what}; name a regular file, or one that is not there yet")
            except (RigError, OSError) as error:
                raise ParameterFileError(f"{path}: {section}: {name}: {error}") from None


def unanswered(sections: Mapping[str, object], namespace: str) -> list[str]:
    """Sections of which no node of a namespace takes anything."""
    nodes = [in_namespace(namespace, node) for node in PARAMETERS]
    return [section for section in sections if not any(_takes(section, node) for node in nodes)]


def given(sections: Mapping[str, Mapping[str, object]], node: str, name: str) -> list[object]:
    """What sections give a node, which is named in full, for this parameter; empty where none does."""
    return [values[name] for section, values in sections.items() if name in values and _takes(section, node)]


def _takes(section: str, node: str) -> bool:
    """Whether a node takes a section, as ROS matches their names."""
    levels = [{"**": ".*", "*": "[^/]+"}.get(level, re.escape(level)) for level in section.strip("/").split("/")]
    return re.fullmatch("/" + "/".join(levels).replace(".*/", "(?:.*/)?"), node) is not None


def _sections(content: object, file: str, path: str) -> Iterator[tuple[str, Mapping]]:
    """Nodes as they are named, and what is given to each."""
    if not isinstance(content, Mapping):
        where = f"{path}: " if path else ""
        raise ParameterFileError(f"{file}: {where}holds {shown(content)}, a node's name with {_SECTION} is needed")
    name = path.rpartition("/")[2]
    for key, value in content.items():
        if key == _SECTION:
            if not path:
                raise ParameterFileError(f"{file}: {_SECTION} stands below no node; valid are {', '.join((*PARAMETERS, *_ANY_NODE))}")
            if not isinstance(value, Mapping):
                raise ParameterFileError(f"{file}: {path}: {_SECTION} holds {shown(value)}, parameters with values are needed")
            yield path, value
        elif name in PARAMETERS or name in _ANY_NODE and not isinstance(value, Mapping):
            raise ParameterFileError(f"{file}: {path}: no section {cited(key)}; the only one is {_SECTION!r}")
        else:
            yield from _sections(value, file, f"{path}/{key}" if path else str(key))


def _flat(given: Mapping, before: str) -> Iterator[tuple[str, object]]:
    """Parameters by their dotted names."""
    for key, value in given.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{key}.")
        else:
            yield f"{before}{key}", value


def _fault(name: str, value: object, declared: list[Parameter]) -> str:
    """Why no node takes a value; '' where all that declare its parameter do."""
    if name.startswith(_FREE):
        return ""
    of_name = [parameter for parameter in declared if parameter.name == name]
    if not of_name:
        return no_such("parameter", name, dict.fromkeys(p.name for p in declared))
    return next((f"{name} is {shown(value)}, {p.must_be(value)}" for p in of_name if not p.takes(value)), "")
