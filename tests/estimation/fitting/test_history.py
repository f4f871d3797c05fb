"""What a unit has been through before a recording: how nodes lie to each other that no sensor reads."""

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.history import RESTS, likely_rise, open_begin, open_motor, open_oil, rests
from ddh_twin_py.physics.thermal_network import N, N_EDGES, N_FLOWS, N_SURFACES, N_WALLS, NODES, capacities, conductances, network_step
from ddh_twin_py.rig import load_rig

AIR = 296.0
ROTOR, HOUSING, WINDING, TEETH = (NODES.index(name) for name in ("rotor", "housing", "end_winding", "teeth"))


@pytest.fixture(scope="module")
def parameters():
    return load_rig().parameters


def worked(parameters, lengths, watts=60.0):
    """Temperatures after so many minutes of copper loss in the winding, K, (m, N)."""
    edge, wall, surface, capacity = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3)), np.empty(N)
    conductances(parameters, edge, wall, surface)
    capacities(parameters, 0.2, capacity)
    heat = np.zeros(N)
    heat[[NODES.index("slot_winding"), WINDING]] = 0.5 * watts
    temperature, course = np.full(N, AIR), []
    for _ in range(max(lengths)):
        course.append(temperature.copy())
        network_step(parameters, edge, wall, surface, capacity, temperature, AIR, heat, 0.0, np.zeros(N_FLOWS), 60.0, np.empty((N + 3, N)))
    return np.array([course[length - 1] for length in lengths])


@pytest.mark.parametrize(("minutes", "rest", "watts"), [(5, 0, 90.0), (23, 3, 45.0), (41, 9, 60.0)])
def test_what_is_not_read_lies_where_work_and_rest_have_left_it(parameters, minutes, rest, watts):
    histories = rests(parameters, worked(parameters, range(1, 60, 2)), AIR, 0.2).reshape(-1, N)
    true = rests(parameters, worked(parameters, [minutes], watts), AIR, 0.2)[0, rest]
    rise = likely_rise(histories, {"end_winding": true[WINDING], "housing": true[HOUSING]}, AIR)
    for node in (ROTOR, TEETH):
        found, as_the_housing = true[HOUSING] + rise[node] - rise[HOUSING], true[HOUSING]
        assert abs(found - true[node]) < max(0.3, 0.35 * abs(as_the_housing - true[node]))


def test_rest_evens_out_and_cools(parameters):
    course = rests(parameters, worked(parameters, [20]), AIR, 0.2)[0] - AIR
    assert course.shape == (RESTS.size, N)
    assert np.all(np.diff(course[:, WINDING]) < 0.0) and course[-1].max() < 0.5 * course[0].max()
    assert course[0, WINDING] - course[0, HOUSING] > 5.0 > abs(course[-1, WINDING] - course[-1, HOUSING])


def test_a_part_of_which_little_is_read_has_no_history(parameters):
    histories = rests(parameters, worked(parameters, [10, 30]), AIR, 0.2).reshape(-1, N)
    assert not likely_rise(histories, {"housing": AIR + 9.0, "pump_1_case": AIR + 3.0}, AIR).any()
    assert not likely_rise(histories, {}, AIR).any()
    motor = likely_rise(histories, {"housing": AIR + 9.0, "end_winding": AIR + 15.0, "tank_oil": AIR + 1.0}, AIR)
    assert motor[ROTOR] > 1.0 and motor[NODES.index("tank_wall")] == 0.0


@pytest.mark.parametrize("watts", [40.0, 110.0])
def test_a_housing_as_cold_as_the_air_leaves_its_winding_open(parameters, watts):
    """After a minute of work a winding is many kelvin ahead of a housing that has hardly begun to rise."""
    histories = rests(parameters, np.vstack([np.full((1, N), AIR), worked(parameters, range(1, 30))]), AIR, 0.2).reshape(-1, N)
    true = worked(parameters, [2], watts)[0]
    ways = open_motor(histories, {"housing": true[HOUSING], "tank_oil": AIR}, AIR)
    assert true[HOUSING] - AIR < 1.0 < 3.0 < true[WINDING] - true[HOUSING] < 2.5 * np.linalg.norm(ways[:, WINDING])
    assert np.allclose(ways[:, HOUSING], 0.0)


def test_a_cold_unit_has_none(parameters):
    histories = rests(parameters, np.vstack([np.full((1, N), AIR), worked(parameters, [10, 30])]), AIR, 0.2).reshape(-1, N)
    rise = likely_rise(histories, {"housing": AIR, "end_winding": AIR, "tank_oil": AIR, "pump_1_case": AIR}, AIR)
    assert np.abs(rise).max() < 0.7


def test_a_motor_of_which_the_housing_alone_is_read_may_begin_as_histories_differ(parameters):
    """What its winding and rotor were ahead of the housing lies within what is left open."""
    histories = rests(parameters, worked(parameters, range(1, 60, 2)), AIR, 0.2).reshape(-1, N)
    for minutes, rest in ((20, 0), (20, 6), (45, 2)):
        true = rests(parameters, worked(parameters, [minutes], 45.0), AIR, 0.2)[0, rest]
        ways = open_motor(histories, {"housing": true[HOUSING], "tank_oil": AIR + 3.0, "tank_wall": AIR + 2.0}, AIR)
        ahead = np.array([true[node] - true[HOUSING] for node in (WINDING, ROTOR, TEETH)])
        most = np.sqrt(np.sum(ways[:, [WINDING, ROTOR, TEETH]] ** 2, axis=0))
        assert ways.shape[0] in (1, 2) and np.all(np.abs(ahead) < 3.0 * most)
        assert not ways[:, HOUSING].any() and not ways[:, NODES.index("tank_oil")].any()


def test_parts_that_hold_oil_and_of_which_nothing_is_read_begin_apart():
    """As far as the tank's oil is warm, each by itself; who reads a node of one knows it."""
    ways = open_oil({"tank_oil": AIR + 10.0, "pump_1_case": AIR + 8.0, "housing": AIR + 4.0}, AIR)
    told = [{name for name, kelvin in zip(NODES, way, strict=True) if kelvin} for way in ways]
    assert told == [{"cylinder_barrel", "chamber_a_oil", "chamber_b_oil"}, {"line_a_wall", "line_a_oil", "line_b_wall", "line_b_oil"},
                    {"tank_wall"}]
    assert np.all(ways[ways != 0.0] == 3.0)
    everywhere = {"tank_oil": AIR + 10.0, "tank_wall": AIR, "cylinder_barrel": AIR, "line_a_wall": AIR, "pump_2_case": AIR}
    for read in ({"tank_oil": AIR + 1.0}, everywhere):  # as warm as the air; every part is read
        assert open_oil(read, AIR).shape == (0, N)


def test_oil_begins_as_warm_as_may_be_where_the_tanks_is_not_read_and_each_unread_part_apart_from_it():
    """All of it together by many kelvin, parts from each other by a share of what the warmest that is read is ahead of the air by."""
    ways = open_oil({"line_a_wall": AIR + 3.0, "pump_2_case": AIR + 4.0, "housing": AIR + 20.0}, AIR)
    together, *apart = [{name for name, kelvin in zip(NODES, way, strict=True) if kelvin} for way in ways]
    assert {"tank_oil", "tank_wall", "cylinder_barrel"} <= together and np.all(ways[0][ways[0] != 0.0] == 8.0)
    assert not {"line_a_wall", "line_a_oil", "line_b_wall", "pump_1_case", "housing", "rotor"} & together
    assert apart == [{"cylinder_barrel", "chamber_a_oil", "chamber_b_oil"}, {"tank_wall"}]
    assert np.allclose(ways[1:][ways[1:] != 0.0], 1.2)
    assert len(open_oil({"line_a_wall": AIR + 1.0}, AIR)) == len(open_oil({"housing": AIR + 20.0}, AIR)) == 1  # as cold as air, or unknown


@pytest.mark.parametrize(("read", "ways"), [({"housing": 0.3}, 1), ({"line_a_wall": 0.3}, 0), ({"line_a_wall": 3.0}, 4)])
def test_the_oil_of_a_cold_unit_is_known_where_a_part_that_holds_it_is_read(read, ways):
    """Histories aside, of which there are none here."""
    assert len(open_begin(np.zeros((0, N)), {node: AIR + rise for node, rise in read.items()}, AIR)) == ways


def test_a_motor_of_which_two_nodes_are_read_and_a_cold_one_are_known(parameters):
    histories = rests(parameters, worked(parameters, [10, 30]), AIR, 0.2).reshape(-1, N)
    assert open_motor(histories, {"housing": AIR + 9.0, "end_winding": AIR + 15.0}, AIR).shape == (0, N)
    assert open_motor(np.zeros((0, N)), {"housing": AIR}, AIR).shape == (0, N)
