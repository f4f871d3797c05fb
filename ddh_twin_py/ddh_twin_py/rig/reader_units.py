"""Values in the units that people read: bar, mm, L/min; inside everything stays SI."""

from __future__ import annotations

import math
from dataclasses import dataclass


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
    "rad/s": Shown("rpm", 30.0 / math.pi, 1),
    "A": Shown("A", 1.0, 3),
    "V": Shown("V", 1.0, 2),
    "W": Shown("W", 1.0, 1),
    "N*m": Shown("N·m", 1.0, 3),
    "m3/s": Shown("L/min", 6e4, 3),
    "m3/(s*Pa)": Shown("mL/(min·bar)", 6e12, 2),
    "Pa*s2/m6": Shown("bar/(L/min)²", 1e-5 / 6e4**2, 4),
    "m3/Pa": Shown("mL/bar", 1e11, 4),
    "N/m": Shown("N/mm", 1e-3, 3),
    "1": Shown("", 1.0, 3),
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
    return f"{written} {s.unit}".rstrip() if with_unit and written != "–" else written


def decimals(value: float, figures: int = 3) -> int:
    """Decimals that show a value with that many significant figures; none below 0."""
    if not math.isfinite(value) or value == 0.0:
        return 0
    return min(9, max(0, figures - 1 - math.floor(math.log10(abs(value)))))


def plain(value: float | None, figures: int = 3) -> str:
    """A number with that many significant figures; a dash where there is none."""
    return "–" if value is None else number(value, decimals(value, figures))


def plus_minus(value: float, std: float | None, unit: str, sign: bool = False) -> str:
    """A value in SI with its standard deviation in the unit that people read, such as `1.83 ± 0.06 L/min`.

    Args:
        unit: of SI. sign: write a plus as well.
    """
    s = shown(unit)
    scaled = value * s.factor
    if std is None or not math.isfinite(std) or std <= 0.0:
        written = plain(scaled)
    else:
        spread = std * s.factor
        digits = min(decimals(spread, 2), max(decimals(scaled, 4), decimals(spread, 1)))
        written = f"{number(scaled, digits)} ± {number(spread, digits)}"
    if sign and scaled > 0.0:
        written = "+" + written
    return f"{written} {s.unit}".rstrip()


def moved(nominal: float, departure: float, unit: str) -> str:
    """The value in SI that a quantity has where it departs from another, in the unit that people read, as finely as shows that it does."""
    s = shown(unit)
    value = (nominal + departure) * s.factor
    return f"{number(value, max(decimals(value), decimals(departure * s.factor, 2)))} {s.unit}".rstrip()


def probably(probability: float) -> str:
    """A probability in percent; one that was weighed is never quite 0 or 1."""
    if probability < 0.005:
        return "< 0.5 %"
    return "> 99.5 %" if probability > 0.995 else f"{100.0 * probability:.0f} %"
