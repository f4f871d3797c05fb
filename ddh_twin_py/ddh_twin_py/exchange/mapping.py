"""The mapping file of a log: which column is which signal, in which unit, and how the file is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, date, datetime
from pathlib import Path

import numpy as np

from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.exchange.units import TIME_UNITS, to_inside, units_for
from ddh_twin_py.names import cited, no_such
from ddh_twin_py.rig import PAYLOADS, is_payload
from ddh_twin_py.rig.numbers import finite_number
from ddh_twin_py.rig.unique_keys import DecimalLoader
from ddh_twin_py.rig.yaml_file import mapping, read_yaml, shown
from ddh_twin_py.telemetry.recording import RigInfo
from ddh_twin_py.telemetry.signals import SIGNALS, TEMPERATURE_PREFIX, Signal, signal_named

SIGNAL_NAMES = tuple(signal.name for signal in SIGNALS)
NEEDED = "speed_command"
DEFAULT_SPACING = 0.1
"""s, least time between two readings of a temperature: 10 Hz, the fastest of the interface."""
ISO = "iso8601"
_ENTRIES = {
    "": ("time", "rig", "csv", "columns"),
    "time": ("column", "unit", "since"),
    "rig": ("rig_id", "oil_grade", "payload_mass_kg"),
    "csv": ("delimiter", "decimal", "encoding", "header_line", "data_line", "comment", "missing"),
}
_OF_COLUMN = ("column", "unit", "factor", "offset")
_OF_TEMPERATURE = (*_OF_COLUMN, "variance_K2", "every_s")


@dataclass(frozen=True)
class ColumnRule:
    """Where a signal comes from: value = factor * cell + offset, in `unit`.

    `variance` K2 and `every` s (least time between two readings) are of temperatures alone.
    """

    signal: Signal
    column: str
    unit: str
    factor: float = 1.0
    offset: float = 0.0
    variance: float = 0.0
    every: float = DEFAULT_SPACING

    def inside(self, cells: np.ndarray) -> np.ndarray:
        """Numbers of the file in the unit inside the project."""
        return to_inside(self.factor * cells + self.offset, self.unit, self.signal.unit)


@dataclass(frozen=True)
class TimeRule:
    """Where the stamps come from: a column of numbers in a unit since a moment (ns since 1970 UTC), or of ISO 8601 texts."""

    column: str
    unit: str
    since_ns: int = 0


@dataclass(frozen=True)
class Dialect:
    """How the file is written; `delimiter` '' is found from the heading, lines count from 1; cells are `missing` by text or value."""

    delimiter: str = ""
    decimal: str = "."
    encoding: str = "utf-8-sig"
    header_line: int = 1
    data_line: int = 2
    comment: str = ""
    missing: tuple[str, ...] = ("", "NaN", "nan", "NAN")
    missing_values: tuple[float, ...] = ()


@dataclass(frozen=True)
class LogMapping:
    """A mapping file, read."""

    file: str
    time: TimeRule
    rig: RigInfo | None
    dialect: Dialect
    columns: tuple[ColumnRule, ...]


def read_mapping(path: str | Path) -> LogMapping:
    """Read a mapping file.

    Raises:
        ExchangeError: file missing or not YAML, an entry that is unknown (with the nearest valid one), missing, or out of range.
    """
    file = str(path)
    tree = mapping(read_yaml(path, "mapping file", ExchangeError, DecimalLoader), file, "mapping file", ExchangeError)
    _known(file, "", tree, _ENTRIES[""])
    parts = {name: _part(file, tree, name) for name in ("time", "rig", "csv")}
    given = tree.get("columns")
    if not isinstance(given, dict) or not given:
        raise ExchangeError(f"{file}: columns: found {shown(given)}, a mapping of signals is needed, such as "
                            "'speed: {column: n, unit: rpm}'")
    rules = tuple(_rule(file, str(name), entry) for name, entry in given.items())
    if NEEDED not in given:
        raise ExchangeError(f"{file}: columns: {NEEDED} is missing, and the twin is driven by it; a drive that logs no command of its "
                            "own: name the column of the measured speed")
    return LogMapping(file, _time(file, parts["time"]), _rig(file, parts["rig"]), _dialect(file, parts["csv"]), rules)


def _part(file: str, tree: Mapping, name: str) -> Mapping:
    entry = tree.get(name) or {}
    if not isinstance(entry, dict):
        raise ExchangeError(f"{file}: {name}: found {cited(entry)}, a mapping is needed")
    _known(file, f"{name}.", entry, _ENTRIES[name])
    return entry


def _known(file: str, where: str, tree: Mapping, valid: tuple[str, ...]) -> None:
    for key in tree:
        if key not in valid:
            raise ExchangeError(f"{file}: {where}{key}: {no_such('entry', key, list(valid))}")
        if where and tree[key] is None:
            raise ExchangeError(f"{file}: {where}{key}: value is missing")


def _rule(file: str, name: str, entry: object) -> ColumnRule:
    where = f"{file}: columns.{name}"
    if name not in SIGNAL_NAMES:
        raise ExchangeError(f"{where}: {no_such('signal', name, list(SIGNAL_NAMES))}")
    if not isinstance(entry, dict):
        raise ExchangeError(f"{where}: found {shown(entry)}, a mapping with column and unit is needed")
    signal, warm = signal_named(name), name.startswith(TEMPERATURE_PREFIX)
    _known(file, f"columns.{name}.", entry, _OF_TEMPERATURE if warm else _OF_COLUMN)
    if "column" not in entry or "unit" not in entry:
        raise ExchangeError(f"{where}: {'column' if 'column' not in entry else 'unit'} is missing; "
                            f"units of {name} are {', '.join(units_for(signal.unit))}")
    unit = str(entry["unit"])
    if unit not in units_for(signal.unit):
        raise ExchangeError(f"{where}.unit: {no_such('unit', unit, list(units_for(signal.unit)))}")
    numbers = {key: finite_number(f"{where}.{key}", entry[key], ExchangeError) for key in ("factor", "offset", "variance_K2", "every_s")
               if key in entry}
    for key, least in (("variance_K2", 0.0), ("every_s", 0.0)):
        if numbers.get(key, 0.0) < least:
            raise ExchangeError(f"{where}.{key}: value is {numbers[key]:g}, allowed are {least:g} and above")
    if numbers.get("factor") == 0.0:
        raise ExchangeError(f"{where}.factor: value is 0, every reading would be the same")
    return ColumnRule(signal, str(entry["column"]), unit, numbers.get("factor", 1.0), numbers.get("offset", 0.0),
                      numbers.get("variance_K2", 0.0), numbers.get("every_s", DEFAULT_SPACING))


def _time(file: str, entry: Mapping) -> TimeRule:
    if "column" not in entry:
        raise ExchangeError(f"{file}: time.column is missing; it names the column with the time of measurement")
    valid = [*TIME_UNITS, ISO]
    unit = str(entry.get("unit", "s"))
    if unit not in valid:
        raise ExchangeError(f"{file}: time.unit: {no_such('unit', unit, valid)}")
    return TimeRule(str(entry["column"]), unit, _moment(file, entry.get("since", "1970-01-01T00:00:00Z")))


def _moment(file: str, given: object) -> int:
    if isinstance(given, str):
        try:
            given = datetime.fromisoformat(given)
        except ValueError:
            pass
    if isinstance(given, date) and not isinstance(given, datetime):
        given = datetime(given.year, given.month, given.day)
    if not isinstance(given, datetime):
        raise ExchangeError(f"{file}: time.since: value is {cited(given)}, a moment such as 2026-05-01T08:00:00Z is needed")
    return iso_to_ns(given)


def iso_to_ns(moment: datetime) -> int:
    """ns since 1970 UTC; a moment without time zone is UTC."""
    aware = moment if moment.tzinfo is not None else moment.replace(tzinfo=UTC)
    since = aware - datetime(1970, 1, 1, tzinfo=UTC)
    return (since.days * 86400 + since.seconds) * 10**9 + since.microseconds * 1000


def _rig(file: str, entry: Mapping) -> RigInfo | None:
    if not entry:
        return None
    payload = float("nan")
    if "payload_mass_kg" in entry:
        payload = finite_number(f"{file}: rig.payload_mass_kg", entry["payload_mass_kg"], ExchangeError)
        if not is_payload(payload):
            raise ExchangeError(f"{file}: rig.payload_mass_kg: value is {payload:g} kg, allowed are {PAYLOADS}")
    return RigInfo(str(entry.get("rig_id", "")), str(entry.get("oil_grade", "")), payload)


def _dialect(file: str, entry: Mapping) -> Dialect:
    default = Dialect()
    texts = {key: str(entry.get(key, getattr(default, key))) for key in ("delimiter", "decimal", "encoding", "comment")}
    texts["delimiter"] = "\t" if texts["delimiter"] in ("tab", "\\t") else texts["delimiter"]
    if len(texts["delimiter"]) > 1:
        raise ExchangeError(f"{file}: csv.delimiter: value is {cited(texts['delimiter'])}, one character is needed (a tabulator: tab)")
    if texts["decimal"] not in (".", ","):
        raise ExchangeError(f"{file}: csv.decimal: value is {cited(texts['decimal'])}, allowed are '.' and ','")
    if texts["decimal"] == texts["delimiter"] != ",":  # a comma may be both where numbers stand in quotes
        raise ExchangeError(f"{file}: csv.decimal and csv.delimiter are both {texts['decimal']!r}")
    try:
        "".encode(texts["encoding"])
    except (LookupError, ValueError):
        raise ExchangeError(f"{file}: csv.encoding: no encoding {cited(texts['encoding'])}; usual are utf-8, latin-1, "
                            "cp1252, utf-16") from None
    if texts["encoding"].lower().replace("_", "-") in ("utf-8", "utf8"):
        texts["encoding"] = default.encoding  # with or without the mark at its beginning
    header = _line(file, "header_line", entry.get("header_line", 1), 1)
    data = _line(file, "data_line", entry.get("data_line", header + 1), header + 1)
    missing = entry.get("missing", [])
    if not isinstance(missing, list):
        raise ExchangeError(f"{file}: csv.missing: found {shown(missing)}, a list of texts and numbers is needed")
    numbers = [value for value in missing if type(value) in (int, float) and value - value == 0]  # infinity and NaN are texts
    return Dialect(**texts, header_line=header, data_line=data,
                   missing=(*default.missing, *(str(text) for text in missing if text not in numbers)),
                   missing_values=tuple(finite_number(f"{file}: csv.missing", value, ExchangeError) for value in numbers))


def _line(file: str, name: str, given: object, least: int) -> int:
    if isinstance(given, bool) or not isinstance(given, int) or given < least:
        raise ExchangeError(f"{file}: csv.{name}: value is {cited(given)}, a whole number from {least} on is needed")
    return given
