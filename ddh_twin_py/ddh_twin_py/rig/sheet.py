"""Read a rig's data sheet: every quantity with its unit, tolerance and source.

A rig file is a YAML mapping of sections. A leaf is ``{value, unit, tolerance, source}``;
``tolerance`` is one relative standard deviation of an independent normal distribution cut
at 2.5. A rig file given by a user may name only what differs from the reference sheet.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import date
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from ddh_twin_py.names import cited, nearest, no_such
from ddh_twin_py.rig.bounds import LARGEST_TOLERANCE, SENSOR_FACTOR, WHOLE, Bound, bound_of, contradiction
from ddh_twin_py.rig.errors import RigError
from ddh_twin_py.rig.numbers import PURE_NUMBER, finite_number
from ddh_twin_py.rig.oil_grades import OF_GRADE, oil_grade
from ddh_twin_py.rig.own_oil import of_own_oil
from ddh_twin_py.rig.unique_keys import DecimalLoader
from ddh_twin_py.rig.yaml_file import mapping, parse_yaml, read_yaml, shown

CUT = 2.5
"""Tolerances are normal distributions cut at this many standard deviations."""
OIL_GRADE = "ISO VG 32"
"""Of the reference sheet's oil."""
LEAF = ("value", "unit", "tolerance", "std", "source")
"""What an entry may say."""
_AN_ENTRY = "{value, unit, tolerance, source}"
SENSOR_ROW = ("noise", "unit", "offset_tolerance", "full_scale", "time_constant", "source")
"""What an entry of a sensor may say."""
_IN_UNIT_OF_SENSOR = ("noise", "offset_tolerance", "full_scale")
_ICE = 273.15  # K
LARGEST_PAYLOAD = 1.0e5
"""kg; a payload that a recording or a duty gives must be above 0 and not above this."""
PAYLOADS = f"above 0 to {LARGEST_PAYLOAD:g} kg"
"""That in words."""


def is_payload(declared: float) -> bool:
    """Whether a payload that is declared, kg, can be one."""
    return 0.0 < declared <= LARGEST_PAYLOAD


@dataclass(frozen=True)
class Quantity:
    """One number of the data sheet.

    Attributes:
        value: in ``unit``.
        unit: SI, written as in the sheet, such as ``W/K``.
        tolerance: one relative standard deviation; 0 is exact.
        source: where the number comes from.
        std: absolute standard deviation in ``unit`` where a fit gave one, else None.
    """

    value: float
    unit: str
    tolerance: float
    source: str
    std: float | None = None

    @property
    def standard_deviation(self) -> float:
        """Absolute standard deviation of the prior or of the fit, in ``unit``."""
        return self.std if self.std is not None else abs(self.value) * self.tolerance


@dataclass(frozen=True)
class SensorSpec:
    """One row of the sheet's sensors: noise of a sample, tolerance of the zero and the size from which readings are saturated, in
    ``unit``; temperatures are saturated from so many K above absolute zero."""

    noise: float
    unit: str
    offset_tolerance: float = 0.0
    full_scale: float | None = None


@dataclass(frozen=True)
class Rig:
    """A rig: quantities by dotted path, sensors, and the same numbers as a compiled-code record.

    Attributes:
        rig_id: name of the rig.
        quantities: dotted path of the sheet (``pump_1.leakage``) to `Quantity`.
        sensors: signal kind (``pressure``, ``temperature``, ...) to `SensorSpec`.
        file: the file that it was read from.
        given: whether that is a rig file that somebody gave, and not the reference sheet.
    """

    rig_id: str
    quantities: Mapping[str, Quantity]
    sensors: Mapping[str, SensorSpec]
    file: str
    given: bool = False

    def __getitem__(self, path: str) -> float:
        return self.quantities[path].value

    @property
    def parameters(self) -> np.ndarray:
        """The quantities as a structured array of shape (1,), the argument of compiled code."""
        record = np.zeros(1, dtype=PARAMETER_DTYPE)
        for path, field in FIELD_OF_PATH.items():
            record[field] = self.quantities[path].value
        return record

    @property
    def named(self) -> bool:
        """Whether it has a name of its own, other than the reference sheet's."""
        return self.rig_id != _REFERENCE.rig_id

    @property
    def oil_grade(self) -> str:
        """Name of the grade of its oil, '' of one that has none: its viscosity was given by itself."""
        own, sheet = (rig.quantities["oil.walther_a"] for rig in (self, _REFERENCE))
        if own.source.startswith(OF_GRADE):
            return own.source.removeprefix(OF_GRADE)
        return OIL_GRADE if own.value == sheet.value else ""

    def may_be_of(self, rig_id: str) -> bool:
        """Whether it may describe the rig that a recording names: the same one, any by the reference sheet, or one without a name."""
        return rig_id in ("", self.rig_id) or not self.named

    def of_another(self, rig_id: str) -> str:
        """That it describes another rig than the one that a recording names; "" where it may be of it, see `may_be_of`."""
        return "" if self.may_be_of(rig_id) else f"the rig file describes {self.rig_id} and the recording is of {rig_id}"

    def declaring(self, payload: float | None) -> Rig:
        """The same rig as a recording or a duty declares its payload, kg; what is no mass, None or NaN or infinite, declares nothing."""
        if payload is None or not 0.0 < payload < math.inf:
            return self
        return self.with_values({"load.payload_mass": payload}, source="declared")

    def with_values(self, values: Mapping[str, float], source: str = "given") -> Rig:
        """The same rig with other values.

        Args:
            values: dotted path to value in the sheet's unit.
            source: where these values come from.

        Raises:
            RigError: for a path that the sheet does not have.
        """
        quantities = dict(self.quantities)
        for path, value in values.items():
            if path not in quantities:
                raise RigError(_unknown(self.file, path, quantities))
            quantities[path] = replace(quantities[path], value=float(value), source=source)
        return replace(self, quantities=quantities)

    def with_oil(self, name: str) -> Rig:
        """The same rig filled with another oil: Walther constants and density change, all else is the sheet's.

        Specific heat, stiffness, air fraction and thermal expansion stay the sheet's: mineral oils differ
        in them by less than its tolerances.

        Args:
            name: of a grade, see `oil_grades.oil_grade`.

        Raises:
            RigError: for a name that is not known.
        """
        grade = oil_grade(name)
        return self.with_values(grade.values(), source=f"{OF_GRADE}{grade.name}")

    def built_as(self, values: Mapping[str, float], source: str) -> Rig:
        """The same kind of rig as it was built, within its tolerances: `with_values`, and coefficients refer to its own oil."""
        built = self.with_values(values, source)
        return replace(built, quantities=of_own_oil(built.quantities, self.quantities))

    def zero_error(self, sensor: str) -> tuple[float, float]:
        """Mean and standard deviation of a sensor's zero error, in its unit.

        Args:
            sensor: ``pressure_piston_side``, ``pressure_rod_side`` or a temperature sensor's name; one
                that has no entry ``measurement.<sensor>_offset`` has the sheet's tolerance around 0.
        """
        spec = self.sensors["pressure" if sensor.startswith("pressure_") else "temperature"]
        known = self.quantities.get(f"measurement.{sensor}_offset")
        if known is None:
            return 0.0, spec.offset_tolerance
        return known.value, known.standard_deviation or spec.offset_tolerance

    def draw(self, rng: np.random.Generator) -> Rig:
        """A rig as it might leave the factory: each quantity drawn within its tolerance, or its fitted deviation.

        Independent normal distributions cut at 2.5 standard deviations (`CUT`) and at the bounds
        that a rig file must keep, where the sheet itself keeps them.
        """
        sound = not contradiction({path: q.value for path, q in self.quantities.items()})
        while True:
            values = {path: _drawn(path, q, rng) for path, q in self.quantities.items() if q.standard_deviation > 0.0}
            if not sound or not contradiction({path: values.get(path, q.value) for path, q in self.quantities.items()}):
                return self.built_as(values, source="drawn within tolerance")


def _drawn(path: str, quantity: Quantity, rng: np.random.Generator) -> float:
    bound = BOUNDS[path]
    while True:
        deviation = rng.standard_normal()
        if quantity.std is None:
            value = quantity.value * (1.0 + quantity.tolerance * deviation)
        else:
            value = quantity.value + quantity.std * deviation
        if abs(deviation) <= CUT and (bound.holds(value) or not bound.holds(quantity.value)):
            return value


def load_rig(path: str | Path | None = None) -> Rig:
    """Read a rig file, or the reference sheet where ``path`` is None.

    Args:
        path: YAML file; entries that it leaves out are those of the reference sheet, and so is what it leaves out of a sensor.
            ``oil: {grade: ISO VG 46}`` stands for the entries that a grade decides (`oil_grades`), with the reference sheet's tolerances.

    Raises:
        RigError: file missing, no regular file or too large, not YAML, an entry given twice or unknown
            (with the nearest valid one), a text that holds a lone surrogate, a unit that is missing or
            another, a value that is no finite number or outside its bounds (`bounds`), or values that
            contradict each other.
    """
    if path is None:
        return _REFERENCE
    tree = mapping(read_yaml(path, "rig file", RigError, DecimalLoader), str(path), "rig file", RigError, "sections")
    tree, grade = _named_oil(tree, str(path))
    _refuse_unknown_sections(tree, str(path))
    _refuse_unknown_sensors(tree.get("sensors"), str(path))
    rig_id, quantities, sensors = _parse(tree, str(path), _REFERENCE.sensors)
    merged = dict(_filled_with(grade, str(path)).quantities) if grade else dict(_REFERENCE.quantities)
    for name, quantity in quantities.items():
        if name not in merged:
            raise RigError(_unknown(str(path), name, merged))
        if quantity.unit and quantity.unit != merged[name].unit:
            raise RigError(
                f"{path}: {name}: unit is {cited(quantity.unit)}, this entry is in {merged[name].unit!r}"
            )
        _within(f"{path}: {name}: value", quantity.value, BOUNDS[name], merged[name].unit)
        if name in WHOLE and not quantity.value.is_integer():
            raise RigError(f"{path}: {name}: value is {quantity.value:g}, a whole number is needed")
        if not quantity.unit and merged[name].unit != PURE_NUMBER:
            raise RigError(f"{path}: {name}: unit is missing, this entry is in {merged[name].unit!r}")
        merged[name] = replace(quantity, unit=merged[name].unit)
        if quantity.std is not None:
            allowed = Bound(0.0, largest_std(name, quantity.value))
            _within(f"{path}: {name}.std: value", quantity.std, allowed, merged[name].unit)
    for name, spec in sensors.items():
        _check_sensor(f"{path}: sensors.{name}", spec, _REFERENCE.sensors[name])
    odd = contradiction({name: quantity.value for name, quantity in merged.items()})
    if odd:
        raise RigError(f"{path}: {odd}")
    return Rig(rig_id or _REFERENCE.rig_id, merged, {**_REFERENCE.sensors, **sensors}, str(path), given=True)


def _refuse_unknown_sections(tree: dict, file: str) -> None:
    """Raise RigError for a section of a name that there is not, whatever it holds."""
    sections = {name.partition(".")[0] for name in _REFERENCE.quantities} | {"rig_id", "sensors"}
    for section in tree:
        if section not in sections:
            raise RigError(_unknown(file, section, sections))


def _refuse_unknown_sensors(section: object, file: str) -> None:
    """Raise RigError for a sensor, or an entry of one, of a name that there is not, whatever it holds."""
    for name, row in section.items() if isinstance(section, dict) else ():
        if name not in _REFERENCE.sensors:
            raise RigError(_unknown(file, f"sensors.{name}", [f"sensors.{sensor}" for sensor in _REFERENCE.sensors]))
        for key in row if isinstance(row, dict) else ():
            if key not in SENSOR_ROW:
                raise RigError(f"{file}: sensors.{name}.{key}: a sensor has {no_such('key', key, SENSOR_ROW)}")


def _named_oil(tree: dict, file: str) -> tuple[dict, str]:
    """The tree without the grade that its oil names, and that name, '' where there is none."""
    oil = tree.get("oil")
    if not isinstance(oil, dict) or "grade" not in oil:
        return tree, ""
    grade = oil["grade"]
    if isinstance(grade, bool) or not isinstance(grade, (str, int)) or not str(grade).strip():
        raise RigError(f"{file}: oil.grade: found {shown(grade)}, the name of a grade is needed, such as ISO VG 46")
    return {**tree, "oil": {entry: node for entry, node in oil.items() if entry != "grade"}}, str(grade)


def _filled_with(grade: str, file: str) -> Rig:
    """The reference sheet's rig with an oil of that grade."""
    try:
        return _REFERENCE.with_oil(grade)
    except RigError as error:
        raise RigError(f"{file}: oil.grade: {error}") from None


def _within(what: str, value: float, bound: Bound, unit: str) -> None:
    if not bound.holds(value):
        unit = "" if unit in ("", "1") else f" {unit}"
        raise RigError(
            f"{what} is {value:g}{unit}, allowed are {bound.lowest:.4g} to {bound.highest:.4g}{unit}; "
            "is it in the right unit?"
        )


def largest_std(name: str, value: float) -> float:
    """Largest standard deviation of an entry, in its unit: of its value or the reference's, or its bounds' width where that is 0."""
    reference, bound = _REFERENCE.quantities[name].value, BOUNDS[name]
    if reference == 0.0:
        return bound.highest - bound.lowest
    # a fit may leave a value near 0 with the deviation of its prior
    return LARGEST_TOLERANCE * max(abs(value), abs(reference)) * (1.0 + 1e-9)


def _check_sensor(where: str, spec: SensorSpec, reference: SensorSpec) -> None:
    if spec.unit and spec.unit != reference.unit:
        raise RigError(f"{where}: unit is {cited(spec.unit)}, this sensor is in {reference.unit!r}")
    noise = Bound(reference.noise / SENSOR_FACTOR, reference.noise * SENSOR_FACTOR)
    _within(f"{where}.noise: value", spec.noise, noise, reference.unit)
    if not spec.unit and reference.unit != PURE_NUMBER:
        raise RigError(f"{where}: unit is missing, this sensor is in {reference.unit!r}")
    zero = Bound(0.0, SENSOR_FACTOR * max(reference.noise, reference.offset_tolerance))
    _within(f"{where}.offset_tolerance: value", spec.offset_tolerance, zero, reference.unit)
    if spec.full_scale is not None and spec.full_scale <= 0.0:
        raise RigError(f"{where}.full_scale: value is {spec.full_scale:g}, it must be above 0")
    if spec.full_scale is not None and reference.unit == "K" and spec.full_scale <= _ICE:
        raise RigError(f"{where}.full_scale: value is {spec.full_scale:g} K; it is the largest temperature that is read, and 473.15 K are "
                       "200 degC")


def _unknown(file: str, name: str, valid: Any) -> str:
    return f"{file}: {name}: no such entry{nearest(name, valid)}"


def _text(value: Any) -> str:
    return "" if value is None else str(value)


def _no_value(file: str, name: str, beside: str = "") -> str:
    return f"{file}: {name}: value is missing{beside}; an entry is {_AN_ENTRY}"


def _number(file: str, name: str, value: Any) -> float:
    return finite_number(f"{file}: {name}", value, RigError)


def _parse(tree: dict, file: str, of_sheet: Mapping[str, SensorSpec]) -> tuple[str, dict[str, Quantity], dict[str, SensorSpec]]:
    quantities: dict[str, Quantity] = {}
    sensors: dict[str, SensorSpec] = {}

    def leaf(name: str, node: dict) -> None:
        for key in node:
            if key not in LEAF:
                point = "; is it behind a decimal comma? YAML has the point" if isinstance(key, int) else ""
                raise RigError(f"{file}: {name}.{key}: an entry has {no_such('key', key, LEAF)}{point}")
        source = node.get("source", "")
        if not isinstance(source, str):
            raise RigError(f"{file}: {name}.source: value is {shown(source)}, a text is needed; put it in quotes")
        tolerance = _number(file, f"{name}.tolerance", node.get("tolerance", 0.0))
        _within(f"{file}: {name}.tolerance: value", tolerance, Bound(0.0, LARGEST_TOLERANCE), "")
        std = node.get("std")
        if std is not None and _number(file, f"{name}.std", std) < 0.0:
            raise RigError(f"{file}: {name}.std: value is {std:g}, it must not be negative")
        quantities[name] = Quantity(
            value=_number(file, name, node["value"]),
            unit=_text(node.get("unit")),
            tolerance=tolerance,
            source=source,
            std=None if std is None else _number(file, f"{name}.std", std),
        )

    def walk(prefix: str, node: Any) -> None:
        if isinstance(node, dict) and "value" in node:
            leaf(prefix, node)
        elif isinstance(node, dict):
            stray = next((key for key in ("unit", "tolerance", "std", "source") if key in node and not isinstance(node[key], dict)), None)
            if stray is not None:
                raise RigError(_no_value(file, prefix, f" beside {stray}"))
            if not node and prefix in _REFERENCE.quantities:
                raise RigError(_no_value(file, prefix))
            if not node and not any(name.startswith(f"{prefix}.") for name in _REFERENCE.quantities):
                raise RigError(_unknown(file, prefix, _REFERENCE.quantities))
            for key, child in node.items():
                walk(f"{prefix}.{key}" if prefix else str(key), child)
        elif node is None:
            raise RigError(_no_value(file, prefix))
        else:
            found = "a list" if isinstance(node, list) else cited(node)
            raise RigError(f"{file}: {prefix}: found {found}, expected {_AN_ENTRY}")

    rig_id = tree.get("rig_id", "")
    if isinstance(rig_id, bool) or not isinstance(rig_id, (str, int, float)):
        quotes = "; put it in quotes" if isinstance(rig_id, (bool, date)) else ""
        raise RigError(f"{file}: rig_id: found {shown(rig_id)}, a name is needed{quotes}")
    for section, node in tree.items():
        if section == "rig_id":
            continue
        if section != "sensors":
            walk(str(section), node)
            continue
        if not isinstance(node, dict):
            raise RigError(f"{file}: sensors: found {shown(node)}, a mapping of sensors is needed")
        for name, row in node.items():
            if not isinstance(row, dict) or not row:
                raise RigError(f"{file}: sensors.{name}: found {shown(row)}, expected some of {{{', '.join(SENSOR_ROW)}}}")
            sheet = of_sheet.get(name, SensorSpec(math.nan, ""))
            scale = row.get("full_scale", sheet.full_scale)
            unit = "" if any(key in row for key in _IN_UNIT_OF_SENSOR) else sheet.unit
            sensors[name] = SensorSpec(
                noise=_number(file, f"sensors.{name}.noise", row.get("noise", sheet.noise)),
                unit=_text(row.get("unit", unit)),
                offset_tolerance=_number(file, f"sensors.{name}.offset_tolerance", row.get("offset_tolerance", sheet.offset_tolerance)),
                full_scale=None if scale is None else _number(file, f"sensors.{name}.full_scale", scale),
            )
            if row.get("time_constant") is not None:
                walk(f"sensors.{name}.time_constant", row["time_constant"])
    return str(rig_id), quantities, sensors


def _field_name(path: str) -> str:
    return "_".join(part for part in path.split(".") if part != "thermal")


def _read_reference() -> Rig:
    folder = resources.files("ddh_twin_py.rig")

    def parsed(file: str) -> tuple[str, dict[str, Quantity], dict[str, SensorSpec]]:
        return _parse(parse_yaml(folder.joinpath(file).read_text(encoding="utf-8"), file, RigError), file, {})

    rig_id, quantities, sensors = parsed("ddh_rig.yaml")
    _, further, _ = parsed("extensions.yaml")
    return Rig(rig_id, {**quantities, **further}, sensors, "ddh_rig.yaml")


_REFERENCE = _read_reference()

BOUNDS: dict[str, Bound] = {path: bound_of(path, q.value) for path, q in _REFERENCE.quantities.items()}
"""Dotted path of the sheet to what a rig file may say."""

FIELD_OF_PATH: dict[str, str] = {path: _field_name(path) for path in _REFERENCE.quantities}
"""Dotted path of the sheet to the field of the compiled-code record."""

PARAMETER_DTYPE = np.dtype([(field, np.float64) for field in FIELD_OF_PATH.values()])
"""Fields of `Rig.parameters`: each quantity in SI."""
