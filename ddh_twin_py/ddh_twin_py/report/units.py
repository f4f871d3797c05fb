"""How values are shown to people: bar, degC, mm; inside everything stays SI."""

from __future__ import annotations

import math

from ddh_twin_py.rig.reader_units import Shown, decimals, in_unit, moved, number, plain, plus_minus, probably, shown

__all__ = ["ZERO_CELSIUS", "Shown", "celsius", "decimals", "duration", "in_file", "in_unit", "moved", "number", "plain", "plus_minus",
           "probably", "shown", "words"]
ZERO_CELSIUS = 273.15  # K


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


def in_file(value: float, std: float) -> str:
    """A value of the rig file with its standard deviation, as `2900 ± 290` or `(1.90 ± 0.07)e-12`."""
    size = max(abs(value), std)
    if size == 0.0 or 1e-3 <= size < 1e6:
        return plus_minus(value, std, "1")
    power = math.floor(math.log10(size))
    return f"({plus_minus(value / 10.0**power, std / 10.0**power, '1')})e{power}"


def words(name: str) -> str:
    """A name of the code as words."""
    return name.replace("_", " ")
