"""The generated motor network: its parts against handbooks, its mesh against refinement, its condensed form against itself."""

import math
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.physics import surface_heat
from ddh_twin_py.physics.balance import OPERATING_DTYPE
from ddh_twin_py.physics.machine_design import carter_factor, design, winding_factor
from ddh_twin_py.physics.motor_condensed import condense, resistances
from ddh_twin_py.physics.motor_geometry import LUMPS, Load, NoSteadyState, motor_network, reference_load
from ddh_twin_py.physics.motor_only import motor_only
from ddh_twin_py.physics.slot_mesh import TEETH, WINDING, YOKE
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.physics.winding_material import hashin_shtrikman, wound_slot
from ddh_twin_py.report.studies.motor_comparison import observed_order, overlay, rated_load, rows, step
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.machine import load_machine
from scipy.integrate import solve_ivp

RIG, MACHINE = load_rig(), load_machine()
ZERO = 273.15


@pytest.fixture(scope="module")
def network():
    return motor_network(MACHINE, RIG, 8)


@pytest.fixture(scope="module")
def small():
    return motor_network(MACHINE, RIG, 2)


@pytest.fixture(scope="module")
def generated(network, tmp_path_factory):
    file = tmp_path_factory.mktemp("rig") / "generated.yaml"
    file.write_text(overlay(condense(network), network))
    return load_rig(file)


# Air and surfaces


@pytest.mark.parametrize("kelvin, conductivity, viscosity, prandtl", [
    (300.0, 26.3e-3, 15.89e-6, 0.707), (350.0, 30.0e-3, 20.92e-6, 0.700), (400.0, 33.8e-3, 26.41e-6, 0.690),
])  # Incropera and DeWitt, Table A.4
def test_air(kelvin, conductivity, viscosity, prandtl):
    gas = surface_heat.air(kelvin)
    assert gas.conductivity == pytest.approx(conductivity, rel=0.02)
    assert gas.kinematic_viscosity == pytest.approx(viscosity, rel=0.02)
    assert gas.prandtl == pytest.approx(prandtl, rel=0.02)


def test_horizontal_cylinder_by_hand():
    """100 mm pipe at 165 degC in air of 23 degC with table values of air at 367 K: Ra 5.07e6, Nu 23.1, h 7.2 W/(m2*K)."""
    nu, alpha, conductivity, prandtl, film = 22.8e-6, 32.8e-6, 0.0313, 0.697, 367.0
    number = 9.81 / film * 142.0 * 0.1**3 / (nu * alpha)
    assert surface_heat.rayleigh(ZERO + 165.0, ZERO + 23.0, 0.1) == pytest.approx(number, rel=0.05)
    nusselt = (0.60 + 0.387 * number ** (1 / 6) / (1 + (0.559 / prandtl) ** (9 / 16)) ** (8 / 27)) ** 2
    assert nusselt == pytest.approx(23.1, rel=0.01)
    assert surface_heat.natural_convection(ZERO + 165.0, ZERO + 23.0, 0.1) == pytest.approx(nusselt * conductivity / 0.1, rel=0.02)


def test_air_gap_conducts_at_rest_and_its_laws_join():
    assert surface_heat.air_gap_nusselt(0.0) == 2.0
    for border in (1700.0, 1e4):
        below, above = surface_heat.air_gap_nusselt(border * 0.999), surface_heat.air_gap_nusselt(border * 1.001)
        assert above == pytest.approx(below, rel=0.03)
    gas = surface_heat.air(330.0)
    assert surface_heat.air_gap(0.0, 0.03, 0.7e-3, 330.0, 0.0) == pytest.approx(gas.conductivity / 0.7e-3)
    assert surface_heat.air_gap(314.0, 0.03, 1.5e-3, 330.0, 0.0) > 1.5 * surface_heat.air_gap(0.0, 0.03, 1.5e-3, 330.0, 0.0)


def test_what_leaves_a_correlation_is_said():
    assert surface_heat.in_range(1e6, 100.0, 3.0) == []
    assert len(surface_heat.in_range(1e13, 1e8, 40.0)) == 3


# Material and design


def test_two_phase_conductivity_lies_between_series_and_parallel():
    assert hashin_shtrikman(0.2, 390.0, 0.0) == pytest.approx(0.2)
    assert hashin_shtrikman(0.2, 390.0, 1.0) == pytest.approx(390.0)
    for share in (0.2, 0.5, 0.8):
        series = 1.0 / (share / 390.0 + (1.0 - share) / 0.2)
        assert series < hashin_shtrikman(0.2, 390.0, share) < share * 390.0 + (1.0 - share) * 0.2
    dry, wet = wound_slot(390.0, 0.25, 0.028, 0.45, 0.0), wound_slot(390.0, 0.25, 0.028, 0.45, 1.0)
    assert wet / dry == pytest.approx(0.25 / 0.028, rel=0.01)


def test_winding_and_carter_factor():
    skew = math.sin(math.pi / 6.0) / (math.pi / 6.0)
    assert winding_factor(18, 3) == pytest.approx(skew)  # one slot per pole and phase
    assert winding_factor(36, 3) == pytest.approx(0.9659 * math.sin(math.pi / 12.0) / (math.pi / 12.0), rel=1e-4)
    assert carter_factor(0.01, 1e-9, 0.001) == pytest.approx(1.0)
    assert carter_factor(0.01, 0.004, 0.001) > carter_factor(0.01, 0.002, 0.001) > 1.0


def test_the_paper_s_voltage_constant_comes_out():
    d = design(MACHINE, RIG["motor.pole_pairs"])
    assert d.voltage_constant == pytest.approx(RIG["motor.voltage_constant"], rel=0.03)


def test_copper_loss_is_the_paper_s_equation_2(network):
    """N_ph N_turn rho L/s I^2 with the end turns counted as length, at 20 degC."""
    m, d = MACHINE, network.sizes
    length = m["winding.turns_per_phase"] * d.mean_turn_length
    expected = 3.0 * m["materials.copper_resistivity_20C"] * length / d.wire_area * 5.0**2
    heat, slope = network.heat(Load(5.0, 0.0, ZERO + 20.0))
    assert heat.sum() == pytest.approx(expected)
    assert slope.sum() == pytest.approx(expected * RIG["motor.copper_temperature_coefficient"])


def test_iron_loss_is_the_paper_s_equation_3(network):
    """Table 1: 0.039 f B^1.6886 W/kg, f = 3 x 25 Hz at 1500 rpm, with this geometry's masses and flux densities."""
    d = network.sizes
    expected = [mass * 0.039 * 75.0 * flux**1.6886 for mass, flux in
                ((d.tooth_mass, d.tooth_flux_density), (d.yoke_mass, d.yoke_flux_density))]
    assert network.iron_losses(50.0 * math.pi) == pytest.approx(expected, rel=1e-9)
    assert network.iron_losses(0.0) == (0.0, 0.0)


# Mesh


@pytest.mark.parametrize("layers", [1, 3, 8])
def test_the_mesh_holds_all_of_the_machine(layers):
    network = motor_network(MACHINE, RIG, layers)
    d, mesh = network.sizes, network.mesh
    region, volume = np.array(mesh.region), np.array(mesh.volume)
    slots, length = MACHINE["stator.slots"], MACHINE["stator.stack_length"]
    iron = MACHINE["materials.core_density"] * MACHINE["stator.stacking_factor"]
    assert iron * volume[region == TEETH].sum() == pytest.approx(d.tooth_mass)
    assert iron * volume[region == YOKE].sum() == pytest.approx(d.yoke_mass)
    assert volume[region == WINDING].sum() == pytest.approx(d.winding_area * slots * length)
    assert sum(area for _, area, _ in mesh.end_plane) == pytest.approx(2.0 * slots * d.copper_area)
    assert sum(area for _, area in mesh.to_gap) == pytest.approx(math.pi * MACHINE["stator.bore"] * length)


def test_refining_the_mesh_converges():
    steps = [step(motor_network(MACHINE, RIG, layers)) for layers in (4, 8, 16)]
    slot = np.diff([s.slot_over_teeth for s in steps])
    hot = np.diff([s.hot_spot for s in steps])
    path = np.diff([s.slot_to_teeth for s in steps])
    for changes in (slot, hot, path):
        assert abs(changes[1]) < 0.6 * abs(changes[0]), changes
    assert abs(hot[1]) < 1.0
    assert observed_order(steps) > 1.0
    assert abs(path[1]) < 0.06 * steps[-1].slot_to_teeth


# Steady state


def test_without_loss_everything_is_ambient(small):
    np.testing.assert_allclose(small.steady(Load(0.0, 0.0, 300.0)), 300.0, atol=1e-6)


def test_heat_made_is_heat_lost(network):
    load = rated_load(MACHINE, RIG)
    temperature = network.steady(load)
    assert network.lost(temperature, load) == pytest.approx(network.made(temperature, load), rel=1e-6)
    assert np.abs(network.flow(temperature, load)).max() < 1e-4


def test_the_hot_spot_is_in_the_middle_of_the_slot_above_its_mean(network):
    temperature = network.steady(rated_load(MACHINE, RIG))
    means = network.means(temperature)
    assert means["slot_winding"] + 1.0 < network.hot_spot(temperature)
    slot = np.flatnonzero(network.part == WINDING)
    hottest = slot[temperature[slot].argmax()]
    place = np.array(network.mesh.place)
    row = slot[place[slot, 0] == place[hottest, 0]]
    assert place[hottest, 1] == place[row, 1].min()  # on the slot's middle line
    assert place[slot, 0].min() < place[hottest, 0] < place[slot, 0].max()  # neither at the bottom nor at the opening
    order = [means[name] for name in ("slot_winding", "teeth", "yoke", "housing")]
    assert order == sorted(order, reverse=True)


def test_more_current_than_the_surface_can_lose_is_said(small):
    with pytest.raises(NoSteadyState, match="no steady state at 40 A"):
        small.steady(Load(40.0, 0.0, 300.0))


@pytest.mark.parametrize("path, value, lump", [
    ("winding.impregnation", 0.3, "slot_winding"), ("housing.interface_gap", 0.00008, "yoke"),
    ("bearings.equivalent_gap", 0.003, "rotor"), ("housing.emissivity", 0.3, "housing"),
])
def test_what_insulates_makes_warmer(small, path, value, lump):
    load = rated_load(MACHINE, RIG)
    worse = motor_network(MACHINE.with_values({path: value}), RIG, 2)
    assert worse.means(worse.steady(load))[lump] > small.means(small.steady(load))[lump] + 0.5


def test_a_mount_that_conducts_cools(small):
    load = rated_load(MACHINE, RIG)
    mounted = motor_network(MACHINE.with_values({"flange.mounting_conductance": 2.0}), RIG, 2)
    assert mounted.means(mounted.steady(load))["slot_winding"] < small.means(small.steady(load))["slot_winding"] - 20.0


# Transient


def test_transient_against_an_independent_integrator(small):
    start, load = np.full(small.size, 296.15), rated_load(MACHINE, RIG)
    time = np.linspace(0.0, 600.0, 301)
    ours = small.transient(time, lambda t: load, start)[-1]
    reference = solve_ivp(
        lambda t, x: small.flow(x, load) / small.capacity, (0.0, 600.0), start, method="BDF", rtol=1e-7, atol=1e-7
    ).y[:, -1]
    np.testing.assert_allclose(ours, reference, atol=2e-3 * (reference.max() - 296.15))


def test_transient_stores_what_is_not_lost(small):
    load = rated_load(MACHINE, RIG)
    time = np.linspace(0.0, 120.0, 241)
    run = small.transient(time, lambda t: load, np.full(small.size, 296.15))
    net = [small.made(x, load) - small.lost(x, load) for x in run]
    assert small.capacity @ (run[-1] - run[0]) == pytest.approx(np.trapezoid(net, time), rel=1e-3)


# Condensed form


def test_resistances_are_symmetric_and_positive(network):
    r = resistances(network)
    np.testing.assert_allclose(r, r.T, rtol=1e-9)
    assert np.all(r > 0.0) and np.all(np.linalg.eigvalsh(r) > 0.0)


def test_slot_to_end_winding_against_the_closed_form(network):
    """Mean to mean along the wires with heat made evenly: copper over a third of both half lengths."""
    d = network.sizes
    wires = 4.0 * MACHINE["stator.slots"] * 0.5 * d.copper_area * MACHINE["materials.copper_conductivity"]
    expected = wires / ((0.5 * MACHINE["stator.stack_length"] + 0.5 * d.end_turn_length) / 3.0)
    assert condense(network).values["motor.thermal.slot_to_end_winding"] == pytest.approx(expected, rel=0.05)


def test_the_overlay_is_a_rig_file_with_provenance(network, generated):
    condensed = condense(network)
    for path, value in condensed.values.items():
        assert generated[path] == pytest.approx(value, rel=1e-4)
        assert "generated from 115U2C with 8 layers" in generated.quantities[path].source
        assert generated.quantities[path].tolerance == RIG.quantities[path].tolerance
    assert generated["pump_1.leakage"] == RIG["pump_1.leakage"]


def lumped(rig, load: Load, seconds: float, interval: float) -> np.ndarray:
    """The twin's own motor at a constant load from ambient on, K, (intervals, 6)."""
    n = round(seconds / interval)
    out = np.empty((n, len(NODES)))
    motor_only(
        rig.parameters, np.full(n, load.speed), np.full(n, load.current), np.full(n, load.current**2), np.full(n, load.ambient),
        interval, np.full(len(NODES), load.ambient), np.zeros(n, dtype=OPERATING_DTYPE), out,
    )
    return out[:, [NODES.index(name) for name in LUMPS]]


def test_the_twin_s_network_with_the_overlay_follows_the_fine_one(network, generated):
    """One formulation against the other: steady within 2 % of each rise, over an hour within 4 % of the largest."""
    load = rated_load(MACHINE, RIG)
    steady = network.means(network.steady(load))
    last = lumped(generated, load, 40 * 3600.0, 20.0)[-1]
    for name, value in zip(LUMPS, last, strict=True):
        assert value - load.ambient == pytest.approx(steady[name] - load.ambient, rel=0.02), name
    time = np.concatenate([np.linspace(0.0, 300.0, 61), np.linspace(330.0, 3600.0, 110)])
    run = network.transient(time, lambda t: load, np.full(network.size, load.ambient))
    fine = np.array([list(network.means(x).values()) for x in run])[1:]
    coarse = lumped(generated, load, 3600.0, 5.0)[(np.rint(time[1:] / 5.0) - 1).astype(int)]
    assert np.abs(fine - coarse).max() < 0.04 * (fine.max() - load.ambient)


def test_the_comparison_counts_in_the_sheet_s_tolerances(network):
    table = {row.path: row for row in rows(condense(network), MACHINE, RIG)}
    row = table["motor.thermal.housing_capacity"]
    assert row.deviations == pytest.approx((row.generated - 2250.0) / 225.0) and row.verdict == "within one"
    assert table["motor.thermal.slot_to_end_winding"].verdict == "outside"
    assert all(row.note for row in table.values() if row.verdict != "within one"), "a difference without a reason"
    exact = replace(RIG, quantities={**RIG.quantities, row.path: replace(RIG.quantities[row.path], tolerance=0.0)})
    assert next(r for r in rows(condense(network), MACHINE, exact) if r.path == row.path).deviations is None
    met = replace(RIG, quantities={**RIG.quantities, row.path: replace(RIG.quantities[row.path], value=row.generated)})
    assert rows(condense(network), MACHINE, met)[-1].path == row.path  # the largest difference first, none last


def test_speed_helps_across_the_air_gap(small):
    """From rest to 6000 rpm the end spaces and the gap carry more; the rotor without losses comes nearer to the teeth."""
    slow, fast = reference_load(MACHINE, 5.0), replace(reference_load(MACHINE, 5.0), speed=628.0)
    start = np.linspace(300.0, 400.0, small.size)
    assert small.variable(start, fast).sum() > small.variable(start, slow).sum()


def test_the_table_of_the_documentation_is_what_comes_out(repo_root):
    text = (repo_root / "docs/motor_network.md").read_text(encoding="utf-8")
    rows_ = [line.strip("| ").split("|") for line in text.splitlines() if line.startswith("| `motor.")]
    documented = {row[0].strip("` "): (float(row[1]), float(row[-1])) for row in rows_}
    table = {row.path: row for row in rows(condense(motor_network(MACHINE, RIG, 12)), MACHINE, RIG)}
    assert set(documented) == set(table)
    for path, (value, deviations) in documented.items():
        assert table[path].generated == pytest.approx(value, rel=2e-3), path
        assert table[path].deviations == pytest.approx(deviations, abs=0.06), path
