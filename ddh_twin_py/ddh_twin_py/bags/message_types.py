"""Message definitions: the telemetry types of the interface, and where the others are found.

The telemetry types are a contract with every bag there is, so their text is kept here and
bags are read without a ROS workspace. The twin's own output types are read from the `.msg`
files of the `ddh_msgs` package, which is there wherever such messages are produced.
"""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, TypesysError, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

TELEMETRY_DEFINITIONS = {
    "ddh_msgs/msg/DriveTelemetry": """\
# What the servo drive measures. Stamp: time of measurement.
std_msgs/Header header      # stamp: time of measurement
float64 speed_command      # rad/s, what the drive was asked for
float64 speed              # rad/s, measured at the motor shaft
float64 torque             # N*m, the drive's estimate (torque constant times current)
float64 current            # A rms, torque-producing (q axis), signed as torque
float64 voltage            # V rms, line to line, not signed
float64 electrical_power   # W, drive output, from the same current measurement
""",
    "ddh_msgs/msg/HydraulicTelemetry": """\
# What the hydraulic sensors measure. Stamp: time of measurement.
std_msgs/Header header          # stamp: time of measurement
float64 pressure_piston_side   # Pa gauge, at the cylinder port
float64 pressure_rod_side      # Pa gauge, at the cylinder port
float64 rod_position           # m, 0 is fully retracted
float64 rod_velocity           # m/s
""",
    "ddh_msgs/msg/RigInfo": """\
# Which rig the telemetry belongs to. Published once, transient local.
std_msgs/Header header    # stamp: time of publication
string rig_id             # which machine, such as its serial number
string oil_grade          # such as "ISO VG 32"
float64 payload_mass      # kg, everything that the rod lifts
""",
}
"""Text of the `ddh_msgs` types that the interface control document fixes, by type name."""


def definition_folders(package: str = "ddh_msgs") -> list[Path]:
    """Folders with the `.msg` files of a package: the sourced workspaces, then the checkout."""
    prefixes = [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    folders = [prefix / "share" / package / "msg" for prefix in prefixes]
    folders.append(Path(__file__).resolve().parents[3] / package / "msg")
    return [folder for folder in folders if folder.is_dir()]


def output_definitions() -> dict[str, str]:
    """Text of the `ddh_msgs` types beyond the telemetry, by type name; empty without the package."""
    for folder in definition_folders():
        return {
            name: path.read_text("utf8")
            for path in sorted(folder.glob("*.msg"))
            if (name := f"ddh_msgs/msg/{path.stem}") not in TELEMETRY_DEFINITIONS
        }
    return {}


@lru_cache(maxsize=1)
def telemetry_typestore() -> Typestore:
    """ROS 2 Jazzy's types and the telemetry types; nothing that depends on a workspace."""
    return _store(TELEMETRY_DEFINITIONS)


@lru_cache(maxsize=1)
def typestore() -> Typestore:
    """ROS 2 Jazzy's types and all of `ddh_msgs` that can be found (telemetry always)."""
    return _store({**TELEMETRY_DEFINITIONS, **output_definitions()})


def _store(definitions: dict[str, str]) -> Typestore:
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for name, text in definitions.items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    return store


def know(message_type: str) -> Typestore:
    """The typestore, with that type in it; a type that it lacks is read from the sourced workspaces.

    Raises KeyError naming the type, or the type that it contains, whose definition is nowhere.
    """
    store = typestore()
    wanted = [message_type]
    types = {}
    while wanted:
        name = wanted.pop()
        if name in store.fielddefs or name in types:
            continue
        package, _, short = name.partition("/")
        short = short.removeprefix("msg/")
        for folder in definition_folders(package):
            file = folder / f"{short}.msg"
            if file.is_file():
                break
        else:
            raise KeyError(f"no definition of {name!r}; source the workspace whose package {package!r} has it")
        try:
            found = get_types_from_msg(file.read_text("utf8"), name)
        except TypesysError as error:
            raise KeyError(f"definition of {name!r} in {file} cannot be parsed: {error}") from None
        types.update(found)
        wanted += [used for _, fields in found.values() for _, kind in fields if (used := _named(kind))]
    if types:
        store.register(types)
    return store


def _named(kind) -> str:
    """Name of the message type that a field is of, '' for a basic type."""
    node, content = kind
    if node is Nodetype.NAME:
        return content
    if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
        return _named(content[0])
    return ""
