"""Read a machine description: slots, dimensions, materials, insulation and gaps of a servo motor.

A description is a YAML mapping of sections; a leaf is ``{value, unit, source}``. A file given by a
user may name only what differs from the 115U2C. ``notes`` says, per quantity of the rig's data
sheet, why the generated value differs from the sheet's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from importlib import resources
from pathlib import Path
from typing import Any

from ddh_twin_py.names import cited, nearest
from ddh_twin_py.rig.numbers import PURE_NUMBER, finite_number
from ddh_twin_py.rig.unique_keys import DecimalLoader
from ddh_twin_py.rig.yaml_file import mapping, parse_yaml, read_yaml, shown


class MachineError(ValueError):
    """A description that cannot be used; the message names file, entry and value."""


@dataclass(frozen=True)
class Entry:
    """One number of a description: value in ``unit`` and where it comes from."""

    value: float
    unit: str
    source: str


@dataclass(frozen=True)
class Machine:
    """A machine: entries by dotted path (``stator.bore``), notes by path of the rig's data sheet, its file."""

    machine_id: str
    entries: Mapping[str, Entry]
    notes: Mapping[str, str]
    file: str

    def __getitem__(self, path: str) -> float:
        return self.entries[path].value

    def with_values(self, values: Mapping[str, float]) -> Machine:
        """The same machine with other values, checked like a file.

        Raises:
            MachineError: unknown entry, value out of bounds, or values that contradict each other.
        """
        tree = {path: {"value": value, "unit": self.entries[path].unit if path in self.entries else ""} for path, value in values.items()}
        return _checked(self.machine_id, _merged(self.entries, tree, "given"), self.notes, "given")


_RANGES: tuple[tuple[str, float, float], ...] = (
    ("stator.slots", 3, 120), ("stator.stacking_factor", 0.8, 1.0), ("winding.turns_per_phase", 1, 5000),
    ("winding.fill", 0.1, 0.75), ("winding.impregnation", 0.0, 1.0), ("winding.end_turn_factor", 1.0, 3.0),
    ("winding.end_turn_straight", 0.0, 0.2),
    ("rotor.magnet_arc", 0.3, 1.0), ("rotor.remanence", 0.1, 1.6), ("rotor.recoil_permeability", 1.0, 2.0),
    ("bearings.preload", 0.0, 1e5), ("bearings.load_friction", 0.0, 0.02), ("bearings.seal_torque", 0.0, 5.0),
    ("bearings.grease_viscosity", 1e-6, 2e-3), ("bearings.grease_factor", 0.5, 15.0),
    ("bearings.equivalent_gap", 1e-5, 5e-3),
    ("housing.corner_chamfer", 0.0, 0.2), ("housing.rib_count", 0, 400), ("housing.rib_height", 0.0, 0.1),
    ("housing.rear_cover_length", 0.0, 0.5), ("*emissivity", 0.0, 1.0),
    ("winding.liner_thickness", 0.0, 3e-3), ("winding.liner_contact_gap", 0.0, 1e-3),
    ("housing.interface_gap", 0.0, 1e-3), ("flange.joint_gap", 0.0, 1e-3), ("rotor.air_gap", 1e-4, 1e-2),
    ("flange.mounting_conductance", 0.0, 100.0),
    ("materials.copper_resistivity_20C", 1.5e-8, 4e-8), ("materials.*conductivity*", 0.02, 500.0),
    ("materials.*_density", 500.0, 2e4), ("materials.*_heat", 100.0, 3000.0),
    ("end_space.still_coefficient", 0.0, 200.0), ("end_space.speed_coefficient", 0.0, 100.0),
    ("end_space.speed_exponent", 0.1, 2.0),
    ("reference.ambient", -60.0, 80.0), ("reference.housing_rise", 1.0, 150.0), ("reference.speed", 0.0, 2e4),
    ("*", 1e-4, 2.0),  # what is left are lengths
)
"""Path pattern, lowest and highest value; the first that fits counts."""

WHOLE = ("stator.slots", "winding.turns_per_phase", "housing.rib_count")
"""Entries that are whole numbers."""


def bounds_of(path: str) -> tuple[float, float]:
    """Lowest and highest allowed value of an entry, in its unit."""
    return next((low, high) for pattern, low, high in _RANGES if fnmatchcase(path, pattern))


def load_machine(path: str | Path | None = None) -> Machine:
    """Read a machine description, or that of the 115U2C where ``path`` is None.

    Raises:
        MachineError: file missing, not YAML, an entry given twice or unknown (with the nearest valid one),
            a unit that is missing or another, a value that is no finite number or out of bounds, or values that contradict each other.
    """
    if path is None:
        return _REFERENCE
    tree = read_yaml(path, "machine description", MachineError, DecimalLoader)
    name, leaves, notes = _flat(tree, str(path))
    return _checked(name or _REFERENCE.machine_id, _merged(_REFERENCE.entries, leaves, str(path)), notes, str(path))


def _flat(tree: Any, file: str) -> tuple[str, dict[str, dict], dict[str, str]]:
    """Name, leaves by dotted path, notes."""
    tree = dict(mapping(tree, file, "machine description", MachineError, "sections"))
    name, notes = tree.pop("machine_id", ""), tree.pop("notes", None) or {}
    if isinstance(name, bool) or not isinstance(name, (str, int, float)):
        raise MachineError(f"{file}: machine_id: found {shown(name)}, a name is needed")
    if not isinstance(notes, dict) or not all(isinstance(text, str) for text in notes.values()):
        raise MachineError(f"{file}: notes: a mapping of quantities to text is needed")
    leaves = {}
    for section, rows in tree.items():
        if not isinstance(rows, dict):
            raise MachineError(f"{file}: {section}: found {shown(rows)}, expected a mapping of entries")
        for key, leaf in rows.items():
            if not isinstance(leaf, dict) or "value" not in leaf:
                raise MachineError(f"{file}: {section}.{key}: found {shown(leaf)}, expected {{value, unit, source}}")
            leaves[f"{section}.{key}"] = leaf
    return str(name), leaves, {str(key): " ".join(text.split()) for key, text in notes.items()}


def _merged(entries: Mapping[str, Entry], leaves: Mapping[str, dict], file: str) -> dict[str, Entry]:
    merged = dict(entries)
    for path, leaf in leaves.items():
        if path not in merged:
            raise MachineError(f"{file}: {path}: no such entry{nearest(path, merged)}")
        unit = "" if leaf.get("unit") is None else str(leaf["unit"])
        if not unit and merged[path].unit != PURE_NUMBER:
            raise MachineError(f"{file}: {path}: unit is missing, this entry is in {merged[path].unit!r}")
        unit = unit or PURE_NUMBER
        if unit != merged[path].unit:
            raise MachineError(f"{file}: {path}: unit is {cited(unit)}, this entry is in {merged[path].unit!r}")
        merged[path] = Entry(_number(leaf["value"], path, file), unit, str(leaf.get("source", "")) or "given")
    return merged


def _number(value: Any, path: str, file: str) -> float:
    return finite_number(f"{file}: {path}", value, MachineError)


def _checked(name: str, entries: Mapping[str, Entry], notes: Mapping[str, str], file: str) -> Machine:
    for path, entry in entries.items():
        low, high = bounds_of(path)
        unit = "" if entry.unit == "1" else f" {entry.unit}"
        if not low <= entry.value <= high:
            raise MachineError(
                f"{file}: {path}: value is {entry.value:g}{unit}, allowed are {low:g} to {high:g}{unit}; is it in the right unit?"
            )
        if path in WHOLE and entry.value != int(entry.value):
            raise MachineError(f"{file}: {path}: value is {entry.value:g}, a whole number is needed")
    machine = Machine(name, entries, notes, file)
    odd = contradiction(machine)
    if odd:
        raise MachineError(f"{file}: {odd}")
    return machine


def contradiction(m: Machine) -> str:
    """What does not fit together although each number is allowed, '' where all fits."""
    slots, bore, depth = m["stator.slots"], m["stator.bore"], m["stator.slot_depth"]
    yoke = 0.5 * (m["stator.outer_diameter"] - bore) - depth
    if yoke <= 0.0:
        return f"stator.slot_depth: value is {depth:g} m, between bore and outer diameter is room for {depth + yoke:g} m"
    if m["stator.tooth_tip_height"] >= depth:
        return f"stator.tooth_tip_height: value is {m['stator.tooth_tip_height']:g} m, the slot is {depth:g} m deep"
    pitch = math.pi * (bore + 2.0 * m["stator.tooth_tip_height"]) / slots
    if m["stator.tooth_width"] + 2.0 * m["winding.liner_thickness"] >= pitch:
        return f"stator.tooth_width: value is {m['stator.tooth_width']:g} m, no slot is left of the pitch of {pitch:.4g} m"
    if m["stator.slot_opening"] >= math.pi * bore / slots:
        return f"stator.slot_opening: value is {m['stator.slot_opening']:g} m, no tooth is left at the bore"
    if slots % 3:
        return f"stator.slots: value is {slots:g}, three phases need a multiple of 3"
    if 6.0 * m["winding.turns_per_phase"] % slots:
        return (
            f"winding.turns_per_phase: value is {m['winding.turns_per_phase']:g}, with {slots:g} slots the conductors per slot "
            f"are {6.0 * m['winding.turns_per_phase'] / slots:g}, not a whole number"
        )
    core = 0.5 * bore - m["rotor.air_gap"] - m["rotor.magnet_thickness"]
    if core <= 0.5 * m["rotor.shaft_diameter"]:
        return f"rotor.magnet_thickness: value is {m['rotor.magnet_thickness']:g} m, nothing is left for the rotor's core"
    if m["housing.across_flats"] <= m["stator.outer_diameter"]:
        return f"housing.across_flats: value is {m['housing.across_flats']:g} m, the stator has {m['stator.outer_diameter']:g} m"
    if m["housing.body_length"] < m["stator.stack_length"] + 2.0 * m["winding.end_winding_overhang"]:
        return f"housing.body_length: value is {m['housing.body_length']:g} m, core and end windings are longer"
    if m["bearings.bore"] >= m["bearings.outer_diameter"]:
        return f"bearings.bore: value is {m['bearings.bore']:g} m, not below bearings.outer_diameter"
    return ""


def _read_reference() -> Machine:
    file = "motor_115u2c.yaml"
    text = resources.files("ddh_twin_py.rig").joinpath(file).read_text(encoding="utf-8")
    name, leaves, notes = _flat(parse_yaml(text, file, MachineError), file)
    entries = {
        path: Entry(_number(leaf["value"], path, file), leaf["unit"], leaf["source"]) for path, leaf in leaves.items()
    }
    return _checked(name, entries, notes, file)


_REFERENCE = _read_reference()
