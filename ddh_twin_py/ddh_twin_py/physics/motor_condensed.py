"""The generated network on the six motor nodes and seven paths of the rig's data sheet.

Heat that is made evenly in each lump and the lump's mean temperature define an exact 6 x 6 matrix of
resistances R = P^T K^-1 P: mean rise above ambient of every lump per watt in every lump. The sheet
has seven paths where R wants up to fifteen, so its conductances are those whose own R comes nearest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse.linalg import splu

from ddh_twin_py.physics.motor_geometry import LUMPS, Load, Network, reference_load
from ddh_twin_py.physics.surface_heat import natural_convection

PATHS = (
    ("slot_to_end_winding", "slot_winding", "end_winding"),
    ("slot_to_teeth", "slot_winding", "teeth"),
    ("end_winding_to_housing", "end_winding", "housing"),
    ("teeth_to_yoke", "teeth", "yoke"),
    ("teeth_to_rotor", "teeth", "rotor"),
    ("yoke_to_housing", "yoke", "housing"),
    ("rotor_to_housing", "rotor", "housing"),
)
"""Conducting paths of the sheet's motor: name below `motor.thermal`, and the two lumps."""


@dataclass(frozen=True)
class Condensed:
    """Quantities of the rig's sheet that a description gives.

    Attributes:
        values: path in the sheet to value in the sheet's unit.
        resistance: R of the fine network, K/W, (6, 6), lumps in the order of `LUMPS`.
        misfit: largest relative difference of an entry of the sheet's R from the fine network's.
    """

    values: dict[str, float]
    resistance: np.ndarray
    misfit: float


def reference_state(network: Network) -> tuple[Load, np.ndarray]:
    """Load and even temperature, K, (n,), at which temperature-dependent conductances are taken: the reference rise."""
    load = reference_load(network.machine)
    return load, np.full(network.size, load.ambient + network.machine["reference.housing_rise"])


def resistances(network: Network) -> np.ndarray:
    """R = P^T K^-1 P, K/W, (6, 6), at the reference state; P spreads a watt over a lump by heat capacity."""
    load, temperature = reference_state(network)
    lu = splu(network.matrix(temperature, load)[0])
    spread = np.zeros((network.size, len(LUMPS)))
    for column, name in enumerate(LUMPS):
        chosen = network.lump == name
        spread[chosen, column] = network.capacity[chosen] / network.capacity[chosen].sum()
    return spread.T @ lu.solve(spread)


def sheet_resistances(conductances: np.ndarray, to_ambient: float) -> np.ndarray:
    """R of the sheet's network, K/W, (6, 6), from conductances (7,), W/K, in the order of `PATHS` and ``to_ambient`` of the surface."""
    k = np.zeros((len(LUMPS), len(LUMPS)))
    for value, (_, a, b) in zip(conductances, PATHS, strict=True):
        i, j = LUMPS.index(a), LUMPS.index(b)
        k[[i, j], [i, j]] += value
        k[[i, j], [j, i]] -= value
    k[LUMPS.index("housing"), LUMPS.index("housing")] += to_ambient
    return np.linalg.inv(k)


def condense(network: Network) -> Condensed:
    """Values of the sheet's motor quantities that this network gives.

    The seven conductances are least squares of R, without the housing's row, each entry against the two lumps'
    own resistances to the housing. The surface is the one that warms the housing lump by what heat in the stator does.
    """
    d = network.sizes
    load, temperature = reference_state(network)
    full = resistances(network)
    own = np.sqrt(np.diag(full)[:-1] - full[:-1, -1])
    scale = np.outer(own, own)
    stator = [LUMPS.index(name) for name in ("slot_winding", "end_winding", "teeth", "yoke")]
    surface = float(1.0 / full[stator, -1].mean())
    even = float(network.to_ambient(temperature, load.ambient).sum())
    exact = -np.linalg.inv(full)
    start = [max(exact[LUMPS.index(a), LUMPS.index(b)], 0.05) for _, a, b in PATHS]

    def misfit(logarithms: np.ndarray) -> np.ndarray:
        found = sheet_resistances(np.exp(logarithms), surface)
        return ((found - full)[:-1, :-1] / scale)[np.triu_indices(len(LUMPS) - 1)]

    found = least_squares(misfit, np.log(start), xtol=1e-13, ftol=1e-13)
    values = {f"motor.thermal.{name}": float(g) for (name, _, _), g in zip(PATHS, np.exp(found.x), strict=True)}
    for name in LUMPS:
        values[f"motor.thermal.{name}_capacity"] = float(network.capacity[network.lump == name].sum())
    values |= _surface(network, load, surface / even)
    values |= {
        "motor.thermal.end_winding_copper_share": d.end_share,
        "motor.phase_resistance_20C": d.resistance_20C,
        "motor.iron.tooth_flux_density": d.tooth_flux_density,
        "motor.iron.yoke_flux_density": d.yoke_flux_density,
        "motor.iron.tooth_mass": d.tooth_mass,
        "motor.iron.yoke_mass": d.yoke_mass,
        "motor.friction_coulomb": d.friction_coulomb,
        "motor.friction_viscous": d.friction_viscous,
    }
    fitted = sheet_resistances(np.exp(found.x), surface)
    return Condensed(values, full, float(np.abs(fitted / full - 1.0).max()))


def _surface(network: Network, load: Load, share: float) -> dict[str, float]:
    """Area, convection and emissivity of the sheet's surface law that lose the same heat at the reference rise.

    Area is what air touches, times `share` (the housing lump is not evenly warm: its flange is cooler); the
    mount's conductance counts as convection; emissivity is the hull's over that area.
    """
    rise = network.machine["reference.housing_rise"]
    area = natural = radiating = 0.0
    for _, wet, hull, diameter in network.surfaces():
        area += wet
        radiating += hull
        natural += wet * natural_convection(load.ambient + rise, load.ambient, diameter)
    natural += network.machine["flange.mounting_conductance"]
    return {
        "motor.thermal.housing_area": area * share,
        "motor.thermal.housing_convection": natural / area / rise**0.25,
        "motor.thermal.housing_emissivity": network.machine["housing.emissivity"] * radiating / area,
    }

