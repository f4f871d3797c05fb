"""The variables of the FMU: names, units, starts, and their references, which the C code counts in the same way."""

from __future__ import annotations

from dataclasses import dataclass

from ddh_twin_py.physics.balance import OPERATING_FIELDS
from ddh_twin_py.physics.cylinder import holding_pressure
from ddh_twin_py.physics.free_run import HYDRAULIC_STEP
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.sheet import BOUNDS, FIELD_OF_PATH, PARAMETER_DTYPE
from ddh_twin_py.telemetry.signals import ZERO_CELSIUS
from ddh_twin_py.twin.intervals import INTERVAL

INPUT, SETTING, PARAMETER, OUTPUT, TEMPERATURE = 0, 100, 1000, 2000, 3000
"""First reference of each group."""
NOW = ("speed", "pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity")
"""Outputs that hold at the communication point; all other powers, flows and torques are means over the step before it."""
_PAYLOAD = "load.payload_mass"  # an input, though the sheet has a value of it
_MEASURED = ("measurement.", "sensors.")  # sections of what measures the rig; the free run measures nothing
_NOT_READ = ("ambient", "motor.rated_torque", "motor.maximum_speed", "motor.thermal.winding_limit")  # by the free run either
_UNITS = {
    "speed": "rad/s", "speed_absolute": "rad/s", "current": "A", "mean_square_current": "A2", "torque": "N.m", "voltage": "V",
    "rod_position": "m", "rod_velocity": "m/s", "cylinder_force": "N", "friction_force": "N",
}
_ENDINGS = (("_torque", "N.m"), ("_power", "W"), ("_pressure", "Pa"), ("_side", "Pa"), ("_flow", "m3/s"), ("_leakage", "m3/s"))


@dataclass(frozen=True)
class Variable:
    """One scalar variable of the FMU, SI, temperatures in K.

    `group` is one of the numbers above; `lowest` and `highest` what it may be set to, None where nothing is said of it.
    """

    reference: int
    name: str
    unit: str
    about: str
    start: float | None = None
    group: int = OUTPUT
    lowest: float | None = None
    highest: float | None = None


def variables(rig: Rig) -> list[Variable]:
    """All variables: inputs, settings of the run, parameters of the rig, outputs, temperatures of the thermal nodes."""
    return [*_inputs(rig), *_settings(rig), *_parameters(rig), *_outputs(), *_temperatures()]


def _inputs(rig: Rig) -> list[Variable]:
    air = ZERO_CELSIUS + rig["ambient"]
    return [
        Variable(INPUT, "speed_command", "rad/s", "what the drive is asked for; positive raises the load", 0.0, INPUT),
        Variable(INPUT + 1, "payload_mass", "kg", "declared, of everything that the rod lifts", rig[_PAYLOAD], INPUT),
        Variable(INPUT + 2, "ambient_temperature", "K", "air around the unit", air, INPUT),
    ]


def _settings(rig: Rig) -> list[Variable]:
    middle = 0.5 * rig["cylinder.stroke"]
    rows = (
        ("start.temperature", "K", "of all nodes at the start", ZERO_CELSIUS + rig["ambient"]),
        ("start.rod_position", "m", "at the start, 0 is fully retracted", middle),
        ("start.pressure_piston_side", "Pa", "gauge, at the start; its own start holds the payload of the rig file",
         holding_pressure(middle, 0.0, rig.parameters[0])),
        ("start.pressure_rod_side", "Pa", "gauge, at the start", 0.0),
        ("solver.longest_interval", "s", "a communication step is cut into equal intervals that are not longer", INTERVAL),
        ("solver.hydraulic_step", "s", "wanted step of pressures, piston and shaft; a whole number fills an interval", HYDRAULIC_STEP),
    )
    return [Variable(SETTING + i, name, unit, about, float(start), SETTING) for i, (name, unit, about, start) in enumerate(rows)]


def _parameters(rig: Rig) -> list[Variable]:
    """What the free run reads of the rig file."""
    path_of = {field: path for path, field in FIELD_OF_PATH.items()}
    record, found = rig.parameters[0], []
    for i, field in enumerate(PARAMETER_DTYPE.names):
        path = path_of.get(field)
        if path is None or path in (_PAYLOAD, *_NOT_READ) or path.startswith(_MEASURED):
            continue
        quantity = rig.quantities[path]
        found.append(Variable(PARAMETER + i, path, _modelica(quantity.unit), f"rig file: {quantity.source or 'no source'}",
                              float(record[field]), PARAMETER, BOUNDS[path].lowest, BOUNDS[path].highest))
    return found


def _outputs() -> list[Variable]:
    found = []
    for i, name in enumerate(OPERATING_FIELDS):
        about = "at the communication point" if name in NOW else "mean over the step before the communication point"
        unit = _UNITS.get(name) or ("W" if name.startswith("loss_") else next(unit for ending, unit in _ENDINGS if name.endswith(ending)))
        found.append(Variable(OUTPUT + i, name, unit, about))
    return found


def _temperatures() -> list[Variable]:
    return [
        Variable(TEMPERATURE + i, f"temperature.{node}", "K", f"thermal node {node}", group=TEMPERATURE) for i, node in enumerate(NODES)
    ]


def _modelica(unit: str) -> str:
    """A unit of the sheet as FMI wants it (Modelica's way): a dot for a product, nothing for a pure number."""
    return "" if unit == "1" else unit.replace("*", ".").replace("^", "")
