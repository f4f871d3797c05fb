"""The thermal network of a motor, generated from its machine description; steady state and transient.

Nodes: the cells of the slot mesh (winding, teeth, yoke), the end winding in cells along its wire,
magnets, rotor core with shaft, housing, flange, and the air of the end spaces. Copper loss follows
the temperature of each cell (paper, eq. 1 and 2), iron loss the flux densities (eq. 3), friction
heats rotor (half) and the two bearing shields.

C_i dT_i/dt = P_i(T_i) + sum_j G_ij(T) (T_j - T_i) - G_ia(T) (T_i - T_a)
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, diags
from scipy.sparse.linalg import splu

from ddh_twin_py.physics import motor, surface_heat
from ddh_twin_py.physics.machine_design import Design, body_perimeters, body_section, design, housing_areas
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.slot_mesh import SlotMesh, divisions, slot_mesh, winding_conductivity
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.machine import Machine

LUMPS = ("slot_winding", "end_winding", "teeth", "yoke", "rotor", "housing")
"""Lumps of the rig's data sheet."""
EXTRA = ("end_winding", "magnets", "rotor_core", "housing", "flange", "end_air")
"""Parts of the network besides the slot mesh."""
LUMP_OF = {"magnets": "rotor", "rotor_core": "rotor", "flange": "housing"}
"""Parts that the sheet counts into another of its lumps; the end-space air is in none."""
_GAMMA = 1.0 - 1.0 / math.sqrt(2.0)


class NoSteadyState(ValueError):
    """A load that the machine cannot carry for ever, or a cycle that does not settle."""


@dataclass(frozen=True)
class Load:
    """What the motor does: rms phase current A, shaft speed rad/s, ambient K."""

    current: float
    speed: float
    ambient: float


@dataclass(frozen=True)
class Network:
    """A generated network of n nodes; `steady` raises `NoSteadyState`.

    Attributes:
        machine, rig, sizes, mesh: what it was made from.
        part: of each node, (n,). capacity: J/K, (n,).
        pairs: (k, 2) nodes, fixed: their conductances at the reference temperature, W/K, (k,).
        copper: copper loss of each node at 20 degC for 1 A rms, W/A^2, (n,), slot and end winding.
        iron_share: of the iron loss in teeth, and in yoke, (2, n). mesh_layers: of the slot.
    """

    machine: Machine
    rig: Rig
    sizes: Design
    mesh: SlotMesh
    part: np.ndarray
    capacity: np.ndarray
    pairs: np.ndarray
    fixed: np.ndarray
    copper: np.ndarray
    iron_share: np.ndarray
    mesh_layers: int

    @property
    def size(self) -> int:
        """Number of nodes."""
        return self.part.size

    def node(self, part: str) -> int:
        """Number of the one node of a part."""
        return int(np.flatnonzero(self.part == part)[0])

    @cached_property
    def lump(self) -> np.ndarray:
        """Lump of the sheet that each node belongs to, '' for the end-space air, (n,)."""
        names = [LUMP_OF.get(part, part) for part in self.part]
        return np.array(["" if name == "end_air" else name for name in names])

    def means(self, temperature: np.ndarray) -> dict[str, float]:
        """Mean temperature of each lump, weighted by heat capacity, K."""
        return {
            name: float(np.average(temperature[self.lump == name], weights=self.capacity[self.lump == name])) for name in LUMPS
        }

    def hot_spot(self, temperature: np.ndarray) -> float:
        """Hottest cell of the slot, K, of temperatures (n,), K."""
        return float(temperature[self.part == "slot_winding"].max())

    @cached_property
    def _fixed_matrix(self) -> csc_matrix:
        return _laplacian(self.size, self.pairs, self.fixed)

    @cached_property
    def _air_pairs(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Pairs joined by air (k, 2): gap, end winding, core's end faces, discs; and the areas of each kind, m2."""
        m = self.machine
        magnets, core, housing, flange, end_air = (
            self.node(name) for name in ("magnets", "rotor_core", "housing", "flange", "end_air")
        )
        ends = np.flatnonzero(self.part == "end_winding")
        radius = 0.5 * m["stator.bore"]
        gap = np.array([area for _, area in self.mesh.to_gap]) * (1.0 - 0.5 * m["rotor.air_gap"] / radius)
        winding = _end_winding_area(m, self.sizes) * _end_shares(ends.size)
        disc = 0.25 * pi * m["stator.outer_diameter"] ** 2
        ring = pi * m["stator.outer_diameter"] * (m["housing.body_length"] - m["stator.stack_length"])
        rotor = 2.0 * pi * (radius - m["rotor.air_gap"]) ** 2
        faces = np.array([*(area for _, area in self.mesh.end_faces), rotor, disc + ring, disc])
        nodes = [*(i for i, _ in self.mesh.end_faces), core, housing, flange]
        pairs = [*((i, magnets) for i, _ in self.mesh.to_gap), *((i, end_air) for i in ends), *((i, end_air) for i in nodes)]
        return np.array(pairs), gap, winding, faces

    def variable(self, temperature: np.ndarray, load: Load) -> np.ndarray:
        """Conductances of the pairs that air joins, W/K, (k,), at temperatures (n,), K, and a load's speed; see `surface_heat`."""
        m = self.machine
        pairs, gap, winding, faces = self._air_pairs
        outer = 0.5 * m["stator.bore"] - m["rotor.air_gap"]
        end = surface_heat.end_space(
            load.speed * outer, m["end_space.still_coefficient"], m["end_space.speed_coefficient"], m["end_space.speed_exponent"]
        )
        between = 0.5 * float(temperature[pairs[: gap.size, 0]].mean() + temperature[pairs[0, 1]])
        across = surface_heat.air_gap(
            load.speed, outer + 0.5 * m["rotor.air_gap"], m["rotor.air_gap"], between, m["materials.inner_emissivity"]
        )
        first = pairs[gap.size, 0]
        inside = (m["stator.slot_depth"] - m["stator.tooth_tip_height"]) / 6.0
        inside /= winding_conductivity(m, self.sizes, temperature[first])[0]
        return np.concatenate([across * gap, winding / (1.0 / end + inside), end * faces])

    def to_ambient(self, temperature: np.ndarray, ambient: float) -> np.ndarray:
        """Conductance of each node to ambient, W/K, (n,): Churchill-Chu and radiation of housing and flange, the mount; K in."""
        m = self.machine
        out = np.zeros(self.size)
        for part, wet, hull, diameter in self.surfaces():
            t = temperature[self.node(part)]
            natural = surface_heat.natural_convection(t, ambient, diameter)
            out[self.node(part)] = natural * wet + surface_heat.radiation(t, ambient, m["housing.emissivity"]) * hull
        out[self.node("flange")] += m["flange.mounting_conductance"]
        return out

    def surfaces(self) -> tuple[tuple[str, float, float, float], ...]:
        """Part, surface that air touches and hull that radiates, m2, and diameter of the correlation, m."""
        m = self.machine
        wet, hull = housing_areas(m)
        edge = 4.0 * m["flange.side"] * m["flange.thickness"]
        diameter = body_perimeters(m)[1] / pi
        return ("housing", wet, hull, diameter), ("flange", edge, edge, diameter)

    def matrix(self, temperature: np.ndarray, load: Load) -> tuple[csc_matrix, np.ndarray]:
        """Conductance matrix K (n, n), W/K, ambient on its diagonal, and the conductances to ambient (n,); temperature (n,), K."""
        ground = self.to_ambient(temperature, load.ambient)
        values = self.variable(temperature, load)
        return self._fixed_matrix + _laplacian(self.size, self._air_pairs[0], values, ground), ground

    def flow(self, temperature: np.ndarray, load: Load) -> np.ndarray:
        """Heat that each node keeps, W, (n,): made in it, less what it passes on; C dT/dt at temperatures (n,), K, under a load."""
        heat, slope = self.heat(load)
        pairs = self._air_pairs[0]
        passed = self.variable(temperature, load) * (temperature[pairs[:, 0]] - temperature[pairs[:, 1]])
        kept = heat + slope * (temperature - ZERO_CELSIUS - 20.0) - self._fixed_matrix @ temperature
        kept -= np.bincount(pairs[:, 0], passed, self.size) - np.bincount(pairs[:, 1], passed, self.size)
        return kept - self.to_ambient(temperature, load.ambient) * (temperature - load.ambient)

    @cached_property
    def _record(self) -> np.record:
        """The rig's parameters with this machine's iron and friction: what the live model's equations take."""
        d = self.sizes
        rig = self.rig.with_values({
            "motor.iron.tooth_mass": d.tooth_mass, "motor.iron.yoke_mass": d.yoke_mass,
            "motor.iron.tooth_flux_density": d.tooth_flux_density, "motor.iron.yoke_flux_density": d.yoke_flux_density,
            "motor.friction_coulomb": d.friction_coulomb, "motor.friction_viscous": d.friction_viscous,
        })
        return rig.parameters.view(np.recarray)[0]

    def iron_losses(self, speed: float) -> tuple[float, float]:
        """Iron loss of teeth and of yoke, W, at ``speed``, rad/s: the live model's (paper, eq. 3) with the geometry's B and masses."""
        # The plain Python of the equations: a few calls do not pay for compiling.
        return motor.iron_losses.py_func(speed, motor.iron_coefficients.py_func(self._record), self._record)

    def heat(self, load: Load) -> tuple[np.ndarray, np.ndarray]:
        """Heat into each node at 20 degC, W, and its rise with the node's temperature, W/K, each (n,)."""
        copper = self.copper * load.current**2
        teeth, yoke = self.iron_losses(load.speed)
        heat = copper + self.iron_share[0] * teeth + self.iron_share[1] * yoke
        friction = motor.friction_loss.py_func(load.speed, self._record)
        heat[self.node("rotor_core")] += 0.5 * friction
        heat[self.node("housing")] += 0.25 * friction
        heat[self.node("flange")] += 0.25 * friction
        return heat, copper * self.rig["motor.copper_temperature_coefficient"]

    def steady(self, load: Load, tolerance: float = 1e-7, most: int = 200) -> np.ndarray:
        """Temperatures (n,), K, at which all heat that is made is lost; conductances and losses at them.

        Args:
            load: constant. tolerance: K, of the last change. most: iterations.

        Raises:
            NoSteadyState: where copper loss grows faster with temperature than the surface can lose it.
        """
        heat, slope = self.heat(load)
        temperature = np.full(self.size, load.ambient + 20.0)
        for _ in range(most):
            k, ground = self.matrix(temperature, load)
            source = heat - slope * (ZERO_CELSIUS + 20.0) + ground * load.ambient
            new = splu((k - diags(slope, format="csc")).tocsc()).solve(source)
            if not np.all(new >= load.ambient - 1e-6) or new.max() > 2000.0:
                break
            step = float(np.abs(new - temperature).max())
            temperature = new
            if step < tolerance:
                return temperature
        raise NoSteadyState(
            f"{self.machine.file}: no steady state at {load.current:.3g} A: "
            "copper loss grows faster with temperature than the surface loses it"
        )

    def transient(self, time: np.ndarray, load, start: np.ndarray) -> np.ndarray:
        """Temperatures (len(time), n), K, over increasing times, s.

        ROS2 (Verwer et al., SIAM J. Sci. Comput. 20 (1999) 1456; L-stable, second order with any matrix), so that
        conductances may follow temperature outside of the matrix.

        Args:
            load: function of time to `Load`. start: (n,), K.
        """
        out = np.empty((len(time), self.size))
        out[0] = temperature = np.array(start, dtype=float)
        for n in range(1, len(time)):
            step, now = time[n] - time[n - 1], load(time[n - 1])
            k = self.matrix(temperature, now)[0] - diags(self.heat(now)[1], format="csc")
            lu = splu((diags(self.capacity, format="csc") + _GAMMA * step * k).tocsc())
            first = lu.solve(self.flow(temperature, now))
            second = lu.solve(self.flow(temperature + step * first, load(time[n])) - 2.0 * self.capacity * first)
            temperature = temperature + step * (1.5 * first + 0.5 * second)
            out[n] = temperature
        return out

    def lost(self, temperature: np.ndarray, load: Load) -> float:
        """Heat lost to ambient, W, at temperatures (n,), K, under a load."""
        return float(self.to_ambient(temperature, load.ambient) @ (temperature - load.ambient))

    def made(self, temperature: np.ndarray, load: Load) -> float:
        """Heat made, W, at temperatures (n,), K, under a load."""
        heat, slope = self.heat(load)
        return float(heat.sum() + slope @ (temperature - ZERO_CELSIUS - 20.0))


def reference_load(machine: Machine, current: float = 0.0) -> Load:
    """The description's reference speed and ambient with a current, A rms."""
    return Load(current, machine["reference.speed"] * motor.RAD_PER_S_OF_RPM, ZERO_CELSIUS + machine["reference.ambient"])


def motor_network(machine: Machine, rig: Rig, layers: int = 8) -> Network:
    """Generate the network of a machine.

    Args:
        machine: description. rig: for pole pairs, iron-loss coefficients and copper's temperature coefficient.
        layers: of the slot's winding along the radius; the rest is refined in proportion.
    """
    m, d = machine, design(machine, rig["motor.pole_pairs"])
    gas_temperature = ZERO_CELSIUS + m["reference.ambient"] + m["reference.housing_rise"]
    mesh = slot_mesh(m, d, layers, gas_temperature)
    cells = divisions(layers).end_cells + 1
    end_share = _end_shares(cells)
    parts = [*mesh.region, *["end_winding"] * cells, *EXTRA[1:]]
    part = np.array(parts)
    base = len(mesh.region)
    ends = range(base, base + cells)
    magnets, core, housing, flange, end_air = range(base + cells, base + cells + 5)

    slots, length = m["stator.slots"], m["stator.stack_length"]
    varnish = m["materials.varnish_density"] * m["materials.varnish_heat"] * m["winding.impregnation"]
    end_copper = d.copper_area * slots * d.end_turn_length
    end_varnish = (d.winding_area - d.copper_area) * slots * d.end_turn_length * varnish
    end_capacity = end_copper * m["materials.copper_density"] * m["materials.copper_heat"] + end_varnish
    inside = 0.25 * pi * m["stator.outer_diameter"] ** 2 * (m["housing.body_length"] - length)
    gas = surface_heat.air(gas_temperature)
    capacity = np.array([
        *mesh.capacity, *(end_capacity * end_share),
        d.magnet_mass * m["materials.magnet_heat"], d.core_mass * m["materials.steel_heat"],
        d.housing_mass * m["materials.housing_heat"], d.flange_mass * m["materials.housing_heat"],
        0.5 * inside * gas.density * surface_heat.AIR_HEAT,
    ])

    edges = list(mesh.faces) + [(i, housing, g) for i, g in mesh.to_housing]
    k_copper, along = m["materials.copper_conductivity"], 0.5 * d.end_turn_length / (cells - 1)
    for i, area, half in mesh.end_plane:
        edges.append((i, ends[0], k_copper * area / half))
    whole = sum(area for _, area, _ in mesh.end_plane)
    edges += [(a, b, k_copper * whole / along) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    edges += _rotor_edges(m, magnets, core, housing, flange, gas.conductivity)
    joint = 4.0 * m["flange.side"] * m["flange.joint_width"]
    through = m["flange.joint_gap"] / gas.conductivity / joint
    through += 0.5 * m["housing.body_length"] / (m["materials.housing_conductivity"] * body_section(m))
    edges.append((housing, flange, 1.0 / through))

    copper = np.zeros(part.size)
    per_square = 3.0 * d.resistance_20C
    slot = np.array(mesh.copper)
    copper[:base] = per_square * (1.0 - d.end_share) * slot / slot.sum()
    copper[list(ends)] = per_square * d.end_share * end_share
    share = np.zeros((2, part.size))
    volume = np.array(mesh.volume)
    for row, name in enumerate(("teeth", "yoke")):
        chosen = part[:base] == name
        share[row, :base][chosen] = volume[chosen] / volume[chosen].sum()
    return Network(
        m, rig, d, mesh, part, capacity, np.array([edge[:2] for edge in edges]), np.array([edge[2] for edge in edges]), copper, share,
        layers,
    )


def _rotor_edges(m: Machine, magnets: int, core: int, housing: int, flange: int, gas: float) -> list[tuple[int, int, float]]:
    """Magnets to core; core through shaft and bearing to each shield, W/K."""
    outer = 0.5 * m["stator.bore"] - m["rotor.air_gap"]
    inner, length = outer - m["rotor.magnet_thickness"], m["stator.stack_length"]
    steel = m["materials.steel_conductivity"]
    arc = 2.0 * pi * m["rotor.magnet_arc"] * length
    to_core = math.log(outer / (0.5 * (outer + inner))) / (m["materials.magnet_conductivity"] * arc) + 0.25 / (steel * arc)
    section = 0.25 * pi * m["rotor.shaft_diameter"] ** 2
    shaft = (m["bearings.distance_from_core"] + 0.5 * m["bearings.width"]) / (steel * section)
    shaft += length / 6.0 / (steel * pi * inner**2)
    middle = 0.5 * (m["bearings.bore"] + m["bearings.outer_diameter"])
    bearing = m["bearings.equivalent_gap"] / (gas * pi * middle * m["bearings.width"])
    side = 1.0 / (shaft + bearing)
    return [(magnets, core, 1.0 / to_core), (core, housing, side), (core, flange, side)]


def _end_shares(nodes: int) -> np.ndarray:
    """Share of the end winding that each node along its wire stands for, the first where the wires leave the core.

    There, where the wires of a coil cross, they have one temperature: the end winding is a chain.
    """
    share = np.ones(nodes)
    share[0] = share[-1] = 0.5
    return share / share.sum()


def _end_winding_area(m: Machine, d: Design) -> float:
    """Surface of both end windings as rings, m2: outer, inner and end face."""
    height = m["stator.slot_depth"] - m["stator.tooth_tip_height"]
    around = 2.0 * pi * d.slot_mid_radius
    return 2.0 * around * (2.0 * m["winding.end_winding_overhang"] + height)


def _laplacian(size: int, pairs: np.ndarray, values: np.ndarray, ground: np.ndarray | None = None) -> csc_matrix:
    i, j = pairs[:, 0], pairs[:, 1]
    diagonal = np.bincount(i, values, size) + np.bincount(j, values, size)
    if ground is not None:
        diagonal += ground
    every = np.arange(size)
    rows, columns = np.concatenate([every, i, j]), np.concatenate([every, j, i])
    return coo_matrix((np.concatenate([diagonal, -values, -values]), (rows, columns)), shape=(size, size)).tocsc()
