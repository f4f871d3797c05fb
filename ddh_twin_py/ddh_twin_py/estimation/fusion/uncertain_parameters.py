"""Which of the rig's numbers the temperature filter holds to be uncertain, and by how much.

Each is a relative deviation with the sheet's tolerance as its standard deviation, a constant
that the filter learns from sensors where they tell it, and else carries into the uncertainty
of the estimates. Unknown heats come last: they wander and are forgotten with a time constant. The indices below are frozen into kernels.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.physics.thermal_network import CAPACITIES, EDGES, N, NODES, SURFACES, TANK, WALLS
from ddh_twin_py.rig import Rig

HEAT_GROUPS = ("copper", "iron", "motor_friction", "seal_friction", "line_a_loss", "line_b_loss")
"""Losses whose size is uncertain as a whole."""
COPPER_AT = HEAT_GROUPS.index("copper")

_HEAT_TOLERANCES = {
    "copper": ("motor.phase_resistance_20C",),
    "iron": ("motor.iron.hysteresis_coefficient", "motor.iron.tooth_flux_density", "motor.iron.tooth_mass"),
    "motor_friction": ("motor.friction_coulomb",),
    "seal_friction": ("cylinder.friction_coulomb",),
    "line_a_loss": ("line_a.pressure_drop_laminar",),
    "line_b_loss": ("line_b.pressure_drop_laminar",),
}

HEAT_SPLITS = (
    ("pump_1.friction_share_to_case", "pump_1_case", {"pump_1_case": 1.0, "pump_1_oil": -1.0}),
    ("pump_2.friction_share_to_case", "pump_2_case", {"pump_2_case": 1.0, "pump_2_oil": -1.0}),
    ("cylinder.friction_share_to_barrel", "cylinder_barrel", {"cylinder_barrel": 1.0, "chamber_a_oil": -0.5, "chamber_b_oil": -0.5}),
)
"""How losses part between nodes: path whose tolerance it is, the node whose heat it scales, and what each node gets of the change."""

PUMPS = ("pump_1", "pump_2")
PUMP_LOSSES = (("friction_pressure",), ("friction_constant", "friction_viscous"), ("leakage",))
"""What the loss of each pump is made of, each as uncertain as the least known of its tolerances: friction that goes with pressure,
friction that goes with speed alone, leakage."""

N_HEAT, N_SPLIT, N_EDGE, N_SURFACE, N_WALL = len(HEAT_GROUPS), len(HEAT_SPLITS), len(EDGES), len(SURFACES), len(WALLS)
N_PUMP_LOSS = len(PUMP_LOSSES)
SPLIT_AT = N_HEAT
SPLIT_SOURCE = np.array([NODES.index(source) for _, source, _ in HEAT_SPLITS])
SPLIT_SHARE = np.zeros((N_SPLIT, N))
for _row, (_, _, _nodes) in zip(SPLIT_SHARE, HEAT_SPLITS, strict=True):
    for _node, _part in _nodes.items():
        _row[NODES.index(_node)] = _part
PUMP_LOSS_AT = SPLIT_AT + N_SPLIT
EDGE_AT = PUMP_LOSS_AT + len(PUMPS) * N_PUMP_LOSS
SURFACE_AT = EDGE_AT + N_EDGE
WALL_AT = SURFACE_AT + N_SURFACE
CAPACITY_AT = WALL_AT + N_WALL
CAPACITY_NODES = np.array([node for _, node in CAPACITIES] + [TANK])
TANK_CAPACITY = CAPACITY_AT + len(CAPACITIES)
"""Of the oil in both layers of the tank."""
END_SHARE_AT = CAPACITY_AT + len(CAPACITY_NODES)
AMBIENT_AT = END_SHARE_AT + 1
LAG_AT = AMBIENT_AT + 1

UNKNOWN_HEATS = (
    ("motor_winding", 2.0, ("slot_winding", "end_winding")),
    ("motor_housing", 5.0, ("housing",)),
    ("pump_1", 3.0, ("pump_1_case",)),
    ("pump_2", 3.0, ("pump_2_case",)),
    ("cylinder", 3.0, ("cylinder_barrel",)),
    ("tank", 5.0, ("tank_oil",)),
)
"""Heat that no model knows (sun, draught, a warm neighbour): name, standard deviation in W (an estimate), nodes that share it alike."""
UNKNOWN_HEAT_TIME = 900.0
"""s, correlation time of these heats, first-order Gauss-Markov: dq/dt = -q / tau + white noise. An estimate."""
N_UNKNOWN_HEATS = len(UNKNOWN_HEATS)
UNKNOWN_HEAT_STD = np.array([deviation for _, deviation, _ in UNKNOWN_HEATS])
UNKNOWN_HEAT_SHARE = np.zeros((N_UNKNOWN_HEATS, N))
"""Share of each unknown heat that enters each node, 1."""
for _row, (_, _, _where) in zip(UNKNOWN_HEAT_SHARE, UNKNOWN_HEATS, strict=True):
    _row[[NODES.index(node) for node in _where]] = 1.0 / len(_where)
UNKNOWN_HEAT_AT = LAG_AT + len(SENSORS)
N_UNCERTAIN = UNKNOWN_HEAT_AT + N_UNKNOWN_HEATS


@dataclass(frozen=True)
class UncertainParameters:
    """Names and prior standard deviations, shape (N_UNCERTAIN,): relative; K for the ambient sensor's offset, W for unknown heats."""

    names: tuple[str, ...]
    prior: np.ndarray


def uncertain_parameters(rig: Rig) -> UncertainParameters:
    """The uncertain numbers of a rig: heats and how they part, what the pumps' losses are made of, conductances, surfaces, capacities,
    copper share, ambient offset, the lag of each sensor, unknown heats."""

    def relative(*paths: str) -> float:
        spread = [rig.quantities[path].standard_deviation / abs(rig[path]) if rig[path] else 0.0 for path in paths]
        return float(np.hypot.reduce(spread))

    names = list(HEAT_GROUPS)
    prior = [relative(*_HEAT_TOLERANCES[group]) for group in HEAT_GROUPS]
    for path, _, _ in HEAT_SPLITS:
        names.append(path)
        prior.append(relative(path))
    for pump in PUMPS:
        for parts in PUMP_LOSSES:
            names.append(f"{pump}.{parts[-1]}")
            prior.append(max(relative(f"{pump}.{part}") for part in parts))
    for path, _, _ in EDGES:
        names.append(path)
        prior.append(relative(path))
    for area, convection, _, _ in SURFACES:
        names.append(convection)
        prior.append(relative(area, convection))
    for path, _ in WALLS:
        names.append(path)
        prior.append(relative(path))
    for path, _ in CAPACITIES:
        names.append(path)
        prior.append(relative(path))
    names.append("tank.oil_volume")
    prior.append(relative("tank.oil_volume", "oil.specific_heat"))
    names.append("motor.thermal.end_winding_copper_share")
    prior.append(relative("motor.thermal.end_winding_copper_share"))
    names.append("ambient_offset")
    prior.append(rig.quantities["surroundings.enclosure_rise"].standard_deviation or rig.sensors["temperature"].offset_tolerance)
    for sensor in SENSORS:
        names.append(f"sensors.{sensor}.time_constant")
        prior.append(relative("sensors.temperature.time_constant"))
    for name, deviation, _ in UNKNOWN_HEATS:
        names.append(f"unknown_heat.{name}")
        prior.append(deviation)
    return UncertainParameters(tuple(names), np.array(prior))
