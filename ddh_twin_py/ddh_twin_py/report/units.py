"""How values are shown to people: bar, degC, mm; inside everything stays SI."""

from __future__ import annotations

import math
from dataclasses import dataclass

ZERO_CELSIUS = 273.15  # K


@dataclass(frozen=True)
class Shown:
    """A unit that people read: name, factor from SI, decimals."""

    unit: str
    factor: float
    digits: int


_SHOWN = {
    "Pa": Shown("bar", 1e-5, 3),
    "m": Shown("mm", 1e3, 2),
    "m/s": Shown("mm/s", 1e3, 2),
    "rad/s": Shown("rad/s", 1.0, 2),
    "N*m": Shown("N·m", 1.0, 3),
    "A": Shown("A", 1.0, 3),
    "V": Shown("V", 1.0, 2),
    "W": Shown("W", 1.0, 1),
}


def shown(unit: str) -> Shown:
    """How a quantity of that SI unit is shown."""
    return _SHOWN.get(unit, Shown(unit, 1.0, 3))


def number(value: float | None, digits: int) -> str:
    """A number with fixed decimals; a dash where there is none."""
    if value is None or not math.isfinite(value):
        return "–"
    written = f"{value:.{digits}f}"
    return written.removeprefix("-") if float(written) == 0.0 else written.replace("-", "−")


def in_unit(value: float | None, unit: str, with_unit: bool = True) -> str:
    """A value in SI, written in the unit that people read."""
    s = shown(unit)
    written = number(None if value is None else value * s.factor, s.digits)
    return f"{written} {s.unit}" if with_unit and written != "–" else written


def celsius(kelvin: float | None, digits: int = 2) -> str:
    """A temperature in degC, without its unit."""
    return number(None if kelvin is None else kelvin - ZERO_CELSIUS, digits)


def duration(seconds: float) -> str:
    """A time span such as `42 s`, `5 min 30 s` or `1 h 02 min`."""
    if seconds < 60.0:
        return f"{seconds:.3g} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def words(name: str) -> str:
    """A name of the code as words."""
    return name.replace("_", " ")
