"""A generated motor beside the rig's data sheet: differences, convergence of the mesh, sensitivities, overlay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import yaml

from ddh_twin_py.physics import surface_heat
from ddh_twin_py.physics.equivalent_current import Comparison, compare, equivalent_current
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.motor_condensed import Condensed, condense
from ddh_twin_py.physics.motor_geometry import ZERO_CELSIUS, Load, Network, motor_network, reference_load
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.machine import Machine, MachineError
from ddh_twin_py.rig.sheet import CUT

SENSITIVE = (
    ("poor impregnation", {"winding.impregnation": 0.3}),
    ("loose slot liner", {"winding.liner_contact_gap": 0.00015}),
    ("lower fill", {"winding.fill": 0.36}),
    ("loose core in the housing", {"housing.interface_gap": 0.00007}),
    ("smaller air gap", {"rotor.air_gap": 0.0005}),
    ("bearings that conduct well", {"bearings.equivalent_gap": 0.00005}),
    ("longer stack with fewer turns", {
        "stator.stack_length": 0.115, "housing.body_length": 0.185, "winding.turns_per_phase": 111,
    }),
)
"""Meaning and other values of assumptions that carry the differences."""
PERIODS = (2.0, 20.0, 60.0, 300.0, 1200.0, 3600.0)
"""Of the cycles on which the equivalent current is tried, s."""
FINEST = 24
"""Layers of the finest mesh: 6570 nodes, a few seconds."""
CYCLE_LAYERS = 4
"""Layers of the mesh on which cycles are run."""


@dataclass(frozen=True)
class Row:
    """One quantity: generated, sheet, the sheet's relative tolerance, and the difference in tolerances.

    Attributes:
        deviations: (generated - sheet) over one standard deviation of the sheet; None where the sheet's is exact.
        verdict: "within one", "within the sheet's range" (2.5 standard deviations) or "outside".
        note: why it differs, from the description.
    """

    path: str
    unit: str
    generated: float
    sheet: float
    tolerance: float
    deviations: float | None
    verdict: str
    note: str


@dataclass(frozen=True)
class Step:
    """One mesh: layers, nodes, hot spot and mean of the slot, winding over teeth, K, at rated current; slot to teeth, W/K."""

    layers: int
    nodes: int
    hot_spot: float
    slot: float
    slot_over_teeth: float
    slot_to_teeth: float


def rows(condensed: Condensed, machine: Machine, rig: Rig) -> list[Row]:
    """Each generated quantity beside the rig's, the largest difference first."""
    found = []
    for path, value in condensed.values.items():
        quantity = rig.quantities[path]
        spread = quantity.standard_deviation
        deviations = (value - quantity.value) / spread if spread > 0.0 else None
        size = abs(deviations) if deviations is not None else np.inf
        verdict = "within one" if size <= 1.0 else "within the sheet's range" if size <= CUT else "outside"
        found.append(Row(path, quantity.unit, value, quantity.value, quantity.tolerance, deviations, verdict, machine.notes.get(path, "")))
    return sorted(found, key=lambda row: -np.inf if row.deviations is None else -abs(row.deviations))


def rated_load(machine: Machine, rig: Rig) -> Load:
    """Current of the rated torque at the description's reference speed and ambient."""
    return reference_load(machine, rig["motor.rated_torque"] / rig["motor.torque_constant"])


def step(network: Network, condensed: Condensed | None = None) -> Step:
    """Figures of one mesh at rated current."""
    temperature = network.steady(rated_load(network.machine, network.rig))
    means = network.means(temperature)
    condensed = condensed or condense(network)
    return Step(
        network.mesh_layers, network.size, network.hot_spot(temperature), means["slot_winding"],
        means["slot_winding"] - means["teeth"], condensed.values["motor.thermal.slot_to_teeth"],
    )


def convergence(machine: Machine, rig: Rig, layers: int, progress=lambda share: None) -> list[Step]:
    """Figures of meshes each twice as fine as the one before: down from twice the layers, where that is not too fine."""
    several = [2 * layers if 2 * layers <= FINEST else layers]
    while len(several) < 4 and several[0] % 2 == 0:
        several.insert(0, several[0] // 2)
    found = []
    for done, n in enumerate(several):
        found.append(step(motor_network(machine, rig, n)))
        progress((done + 1) / len(several))
    return found


def observed_order(steps: Sequence[Step]) -> float:
    """Order of convergence that the last three meshes show (each twice as fine): log2 of the ratio of differences."""
    a, b, c = (s.slot_over_teeth for s in steps[-3:])
    return float(np.log2(abs((a - b) / (b - c)))) if b != c and a != b else float("nan")


@dataclass(frozen=True)
class Sensitivity:
    """What other assumptions would change: their meaning and values, and relative changes of generated quantities."""

    meaning: str
    values: dict[str, float]
    changes: dict[str, float]


def sensitivities(machine: Machine, rig: Rig, layers: int) -> list[Sensitivity]:
    """Each of `SENSITIVE` that the machine allows, with the changes above 3 %, on a mesh of so many layers."""
    base = condense(motor_network(machine, rig, layers)).values
    found = []
    for meaning, values in SENSITIVE:
        try:
            other = machine.with_values(values)
        except MachineError:
            continue  # such as a stack that does not fit another machine
        changed = condense(motor_network(other, rig, layers)).values
        changes = {name: changed[name] / value - 1.0 for name, value in base.items() if value}
        found.append(Sensitivity(meaning, values, {name: c for name, c in changes.items() if abs(c) > 0.03}))
    return found


def cycles(machine: Machine, rig: Rig, progress=lambda share: None) -> list[Comparison]:
    """The paper's equivalent current against time-resolved cosine cycles; its constant current is the rated one."""
    network = motor_network(machine, rig, CYCLE_LAYERS)
    load = rated_load(machine, rig)
    amplitude = load.current / equivalent_current(1.0)
    found = []
    for done, period in enumerate(PERIODS):
        found.append(compare(network, amplitude, period, load))
        progress((done + 1) / len(PERIODS))
    return found


def out_of_range(network: Network) -> list[str]:
    """Correlations that the rated state and the rig's maximum speed leave; empty where none."""
    m = network.machine
    load = rated_load(m, network.rig)
    housing = network.means(network.steady(load))["housing"]
    speed = network.rig["motor.maximum_speed"] * RAD_PER_S_OF_RPM
    radius = 0.5 * m["stator.bore"] - m["rotor.air_gap"]
    return surface_heat.in_range(
        surface_heat.rayleigh(housing, load.ambient, network.surfaces()[0][3]),
        surface_heat.taylor_number(speed, radius, m["rotor.air_gap"], housing), speed * radius,
    )


def overlay(condensed: Condensed, network: Network) -> str:
    """A rig file with the generated quantities; tolerances stay the sheet's, since a description states none."""
    tree: dict = {"rig_id": f"{network.rig.rig_id}_{network.machine.machine_id}"}
    source = f"generated from {network.machine.machine_id} with {network.mesh_layers} layers ({network.machine.file})"
    for path, value in condensed.values.items():
        quantity = network.rig.quantities[path]
        node = tree
        *sections, name = path.split(".")
        for section in sections:
            node = node.setdefault(section, {})
        node[name] = {"value": float(f"{value:.5g}"), "unit": quantity.unit, "tolerance": quantity.tolerance, "source": source}
    return yaml.safe_dump(tree, sort_keys=False, width=200)


def as_json(network: Network, condensed: Condensed, table: Sequence[Row], steps: Sequence[Step], runs: Sequence[Comparison]) -> dict:
    """Everything that the verb prints, temperatures in degC."""
    load = rated_load(network.machine, network.rig)
    temperature = network.steady(load)
    return {
        "machine": network.machine.machine_id, "description": network.machine.file, "rig": network.rig.file,
        "layers": network.mesh_layers, "nodes": network.size, "misfit": condensed.misfit,
        "quantities": [asdict(row) for row in table],
        "rated": {
            "current_A": load.current, "speed_rad_per_s": load.speed, "ambient_degC": load.ambient - ZERO_CELSIUS,
            "means_degC": {k: v - ZERO_CELSIUS for k, v in network.means(temperature).items()},
            "hot_spot_degC": network.hot_spot(temperature) - ZERO_CELSIUS,
            "heat_W": network.made(temperature, load), "lost_W": network.lost(temperature, load),
        },
        "convergence": [
            asdict(s) | {"hot_spot": s.hot_spot - ZERO_CELSIUS, "slot": s.slot - ZERO_CELSIUS} for s in steps
        ],
        "observed_order": observed_order(steps) if len(steps) > 2 else None,
        "equivalent_current": [
            asdict(c) | {name: getattr(c, name) - ZERO_CELSIUS for name in ("steady", "mean", "largest")} for c in runs
        ],
        "out_of_range": out_of_range(network),
        "design": asdict(network.sizes),
    }
