"""Oils by grade: from viscosity at 40 degC and viscosity index to the quantities of the sheet.

Walther (ASTM D341): log10(log10(nu/cSt + 0.7)) = A - B log10(T/K), through nu at 40 and 100 degC.
The viscosity index (ASTM D2270) ties nu at 100 degC, Y, to nu at 40 degC, U:
VI = 100 (L - U)/(L - H) up to 100, beyond it VI = 100 + (10^N - 1)/0.00715 with
N = (log H - log U)/log Y, where L and H are quadratic in Y by ranges.

The viscosity at which coefficients are stated stays that of the rig's first oil at 23 degC.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from importlib import resources

from ddh_twin_py.names import no_such
from ddh_twin_py.rig.errors import RigError
from ddh_twin_py.rig.yaml_file import parse_yaml

OF_GRADE = "oil_grades.yaml, "
"""Begin of the source of what a grade of oil decides, which its name follows."""
_RANGES = (  # up to Y; L = a Y^2 + b Y + c; H = d Y^2 + e Y + f (ASTM D2270, from Y = 2)
    (3.8, 1.14673, 1.7576, -0.109, 0.84155, 1.5521, -0.077),
    (4.4, 3.38095, -15.4952, 33.196, 0.78571, 1.7929, -0.183),
    (5.0, 2.5000, -7.2143, 13.812, 0.82143, 1.5679, 0.119),
    (6.4, 0.10100, 16.6350, -45.469, 0.04985, 9.1613, -18.557),
    (7.0, 3.35714, -23.5643, 78.466, 0.22619, 7.7369, -16.656),
    (7.7, 0.01191, 21.4750, -72.870, 0.79762, -0.7321, 14.610),
    (9.0, 0.41858, 16.1558, -56.040, 0.05794, 10.5156, -28.240),
    (12.0, 0.88779, 7.5527, -16.600, 0.26665, 6.7015, -10.810),
    (15.0, 0.76720, 10.7972, -38.180, 0.20073, 8.4658, -22.490),
)


@dataclass(frozen=True)
class OilGrade:
    """An oil: name, viscosity at 40 degC (mm2/s), viscosity index, density at 15 degC (kg/m3), pour point (degC)."""

    name: str
    viscosity_40C: float
    viscosity_index: float
    density_15C: float
    pour_point: float

    @property
    def viscosity_100C(self) -> float:
        """mm2/s, from the viscosity index."""
        return viscosity_at_100(self.viscosity_40C, self.viscosity_index)

    @property
    def walther(self) -> tuple[float, float]:
        """A and B of the Walther law through the viscosities at 40 and 100 degC."""
        cold, hot = math.log10(313.15), math.log10(373.15)
        w_cold, w_hot = (math.log10(math.log10(nu + 0.7)) for nu in (self.viscosity_40C, self.viscosity_100C))
        b = (w_cold - w_hot) / (hot - cold)
        return w_cold + b * cold, b

    def viscosity(self, celsius: float) -> float:
        """Kinematic viscosity, mm2/s, at a temperature in degC."""
        a, b = self.walther
        return 10.0 ** 10.0 ** (a - b * math.log10(celsius + 273.15)) - 0.7

    def values(self) -> dict[str, float]:
        """Dotted path of the sheet to value."""
        a, b = self.walther
        return {"oil.walther_a": a, "oil.walther_b": b, "oil.density_15C": self.density_15C}


def viscosity_index(viscosity_40C: float, viscosity_100C: float) -> float:
    """Viscosity index (ASTM D2270) of an oil with these viscosities, mm2/s, that at 100 degC from 2 to 15 mm2/s.

    Raises:
        RigError: for a viscosity at 100 degC beyond that range.
    """
    u, y = viscosity_40C, viscosity_100C
    if not 2.0 <= y <= _RANGES[-1][0]:
        raise RigError(f"viscosity at 100 degC is {y:g} mm2/s, the viscosity index is stated here for 2 to {_RANGES[-1][0]:g} mm2/s")
    _, a, b, c, d, e, f = next(row for row in _RANGES if y <= row[0])
    low, high = a * y * y + b * y + c, d * y * y + e * y + f
    if u >= high:
        return 100.0 * (low - u) / (low - high)
    return 100.0 + (10.0 ** ((math.log10(high) - math.log10(u)) / math.log10(y)) - 1.0) / 0.00715


def viscosity_at_100(viscosity_40C: float, index: float) -> float:
    """Viscosity at 100 degC, mm2/s, of an oil with that index: `viscosity_index` solved by bisection."""
    low, high = 2.0, min(_RANGES[-1][0], viscosity_40C)
    for _ in range(60):
        middle = 0.5 * (low + high)
        if viscosity_index(viscosity_40C, middle) < index:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@cache
def oil_grades() -> dict[str, OilGrade]:
    """Name to oil, in the order of `oil_grades.yaml`."""
    file = "oil_grades.yaml"
    tree = parse_yaml(resources.files("ddh_twin_py.rig").joinpath(file).read_text(encoding="utf-8"), file, RigError)
    return {
        name: OilGrade(name, **{entry: float(leaf["value"]) for entry, leaf in entries.items()})
        for name, entries in tree.items()
    }


def oil_grade(name: str) -> OilGrade:
    """The oil of that name; ``VG 32`` or ``32`` mean ``ISO VG 32``.

    Raises:
        RigError: for a name that is not known, with the nearest that is.
    """
    known = oil_grades()
    wanted = {known_name.upper(): known_name for known_name in known}
    wanted |= {key.removeprefix("ISO "): value for key, value in wanted.items() if key.startswith("ISO ")}
    wanted |= {key.removeprefix("VG "): value for key, value in wanted.items() if key.startswith("VG ")}
    given = " ".join(name.replace("_", " ").upper().split())
    if given not in wanted:
        raise RigError(no_such("oil grade", name, known))
    return known[wanted[given]]
