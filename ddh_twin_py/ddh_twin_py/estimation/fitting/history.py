"""What a unit has likely been through before a recording begins, and how warm that leaves what no sensor reads.

A rotor or a stack that no sensor reads may be far from the housing: ahead of it while the unit works, behind while it rests.
So the twin makes histories of the recording's own duty from ambient, of some length and with some rest after it, and those that
agree with the first readings say how nodes lie to each other. The readings themselves stay what they are.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.thermal_network import (
    HYDRAULIC_NODES,
    N,
    N_EDGES,
    N_FLOWS,
    N_SURFACES,
    N_WALLS,
    NODES,
    capacities,
    conductances,
    network_step,
)

TANK_OIL = "tank_oil"
"""Node whose warmth tells how long a unit has rested."""
RESTS = np.concatenate([[0.0], np.geomspace(60.0, 7200.0, 14)])
"""s of rest after the work, that are tried."""
_OF_MOTOR = np.isin(np.arange(N), [NODES.index(name) for name in ("slot_winding", "end_winding", "teeth", "rotor", "yoke", "housing")])
_SPEAK = 2  # nodes of a part that must be read
_WAYS, _NOTICEABLE = 2, 0.5  # in which what is not read may begin otherwise; K that one must move a node
_WIDER = 1.5  # than such histories differ, as none is the true one
_REST_STEP = 30.0  # s
_OIL_PARTS = (("cylinder_barrel", "chamber_a_oil", "chamber_b_oil"), ("line_a_wall", "line_a_oil", "line_b_wall", "line_b_oil"),
              ("pump_1_case", "pump_1_oil", "pump_2_case", "pump_2_oil"), ("tank_wall",))
"""What oil flows through and cools by itself; who reads one node of a part knows the part."""
_UNLIKE = 0.3  # of what the oil that is read is warmer than the air, by which such a part may be as no history has it
_READ = 1.0  # K, of a first reading: zero errors, and that no history is the true one
_COLD = 1.0  # K from ambient, within which a unit has likely rested
_OIL_OPEN = 8.0  # K, standard deviation of how warm oil begins where the tank's is not read
_ROUNDS, _WORKED_EVERY = 2, 60.0  # of the recording's own duty; s between the lengths of work that are tried
_OTHER_DUTY = 0.35  # of the logarithm of the ratio in which another duty would have warmed the unit


def cold(read: Mapping[str, float], air: float) -> bool:
    """If all that is read, node to K, begins as warm as the air, K: such a unit has likely rested."""
    return all(abs(value - air) < _COLD for value in read.values())


def histories(parameters: np.ndarray, work: Callable[[np.ndarray], np.ndarray], step: float, air: float, position: float) -> np.ndarray:
    """Temperatures of every node at the end of what a unit may have been through, K, (h, N).

    Args:
        parameters: record (1,). work: temperatures of the own duty, K, (m, N), each ``step`` s, of a unit that begins as warm as (N,) says.
        air: K, in which it began. position: of the rod, m.
    """
    worked, temperature = [np.full((1, N), air)], np.full(N, air)
    for _ in range(_ROUNDS):
        temperatures = work(temperature)
        worked.append(temperatures[:: max(1, round(_WORKED_EVERY / step))])
        temperature = temperatures[-1].copy()
    return rests(parameters, np.vstack(worked), air, position).reshape(-1, N)


def rests(parameters: np.ndarray, worked: np.ndarray, air: float, position: float) -> np.ndarray:
    """Temperatures after each of `RESTS` without any heat, K, (m, len(RESTS), N), of a unit that was as warm as (m, N) says.

    Args:
        parameters: record (1,). air: K. position: of the rod, m.
    """
    ends = np.round(RESTS / _REST_STEP).astype(np.int64)
    out = np.empty((len(worked), ends.size, N))
    _cool_down(parameters, np.ascontiguousarray(worked), air, position, ends, out)
    return out


@kernel
def _cool_down(parameters, worked, air, position, ends, out):
    """Write temperatures after each of sorted numbers ``ends`` of rest steps into ``out``; see `rests`."""
    edge, wall, surface, capacity = np.empty(N_EDGES), np.empty(N_WALLS), np.empty((N_SURFACES, 3)), np.empty(N)
    conductances(parameters, edge, wall, surface)
    capacities(parameters, position, capacity)
    heat, flow, work = np.zeros(N), np.zeros(N_FLOWS), np.empty((N + 3, N))
    for i in range(worked.shape[0]):
        temperature = worked[i].copy()
        done = 0
        for j in range(ends.size):
            while done < ends[j]:
                network_step(parameters, edge, wall, surface, capacity, temperature, air, heat, 0.0, flow, _REST_STEP, work)
                done += 1
            out[i, j] = temperature


def likely_rise(histories: np.ndarray, read: Mapping[str, float], air: float) -> np.ndarray:
    """Rise of every node above air, K, (N,), as histories give it that agree with what was read first: their mean by how well.

    A part of the unit, motor or all that holds oil, of which fewer than two nodes are read has no history: 0. So has a cold unit.

    Args:
        histories: temperatures of every node at the end of each, K, (h, N); none of a cold unit. read: node to K.
        air: K, from which they began.
    """
    rise, nodes = histories - air, [NODES.index(name) for name in read]
    if not len(histories) or cold(read, air):
        return np.zeros(N)
    scale, weight = _agreement(rise[:, nodes], np.array(list(read.values())) - air)
    likely = (weight * scale) @ rise / weight.sum()
    for part in (_OF_MOTOR, ~_OF_MOTOR):
        if np.count_nonzero(part[nodes]) < _SPEAK:
            likely[part] = 0.0
    return likely


def open_begin(histories: np.ndarray, read: Mapping[str, float], air: float) -> np.ndarray:
    """Ways in which what no sensor reads may begin otherwise than `likely_rise` lets it, K, (c, N); arguments as there.

    A unit as warm as the air has likely rested. A minute of work, though, warms a winding by many kelvin and a housing by
    less than one; so of a cold unit, too, an unread motor is open. Its oil is not where a part that holds oil is read.
    """
    rested = cold(read, air) and any(node in HYDRAULIC_NODES for node in read)
    return np.vstack([open_motor(histories, read, air), np.zeros((0, N)) if rested else open_oil(read, air)])


def open_motor(histories: np.ndarray, read: Mapping[str, float], air: float) -> np.ndarray:
    """How far the motor's nodes may begin from where `likely_rise` lets them, K, (c, N): the two main ways in which histories differ.

    As often as not a recording begins straight after work: such histories count as much as those of all rests. None, (0, N), where
    two of the motor's nodes are read; all that is known is then in the mean. Arguments as of `likely_rise`, histories as of `rests`.
    """
    rise = histories - air
    nodes = [NODES.index(name) for name in read]
    own = [node for node in nodes if _OF_MOTOR[node]]
    if len(own) >= _SPEAK or not nodes or not len(histories):
        return np.zeros((0, N))
    heard = own or nodes
    scale, weight = _agreement(rise[:, heard], np.array([read[NODES[node]] for node in heard]) - air)
    weight = weight.reshape(-1, RESTS.size) * np.where(RESTS == 0.0, RESTS.size - 1.0, 1.0)
    weight = (weight / weight.sum()).ravel()
    ahead = scale[:, None] * np.where(_OF_MOTOR, rise - (rise[:, own] if own else 0.0), 0.0)
    _, size, ways = np.linalg.svd(np.sqrt(weight)[:, None] * ahead, full_matrices=False)
    found = _WIDER * (size[:, None] * ways)[:_WAYS]
    return found[np.abs(found).max(axis=1) > _NOTICEABLE]


def open_oil(read: Mapping[str, float], air: float) -> np.ndarray:
    """How far what holds oil and is not read may begin from where `likely_rise` lets it, K, (c, N); arguments as there.

    Each part of which nothing is read, as no reading elsewhere tells how fast a barrel cools beside it; none of a unit whose oil is as warm
    as the air. Where the tank's oil is not read, first of all that oil and these parts alike.
    """
    unread = [part for part in _OIL_PARTS if not any(node in read for node in part)]
    warm = [abs(value - air) for node, value in read.items() if node in HYDRAULIC_NODES]
    apart = _UNLIKE * (abs(read[TANK_OIL] - air) if TANK_OIL in read else max(warm, default=0.0))
    told = {*read, *(node for part in _OIL_PARTS if part not in unread for node in part)}
    alike = [] if TANK_OIL in read else [[_OIL_OPEN * (node in HYDRAULIC_NODES and node not in told) for node in NODES]]
    each = [[apart * (node in part) for node in NODES] for part in unread] if apart > _NOTICEABLE else []
    return np.array([*alike, *each]).reshape(-1, N)


def _agreement(own: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """By how much the heat of each history, rises (h, n), would have to be another one for rises (n,), and its weight, (h,) each."""
    scale = np.maximum((own @ wanted + _READ**2) / (np.sum(own**2, axis=1) + _READ**2), 1.0e-2)  # little heat may be any duty's
    cost = np.sum((wanted - scale[:, None] * own) ** 2, axis=1) / _READ**2 + (np.log(scale) / _OTHER_DUTY) ** 2
    return scale, np.exp(-0.5 * (cost - cost.min()))
