"""What the models say, from their messages to the rows that the fusion aligns with the sensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading
from ddh_twin_py.nodes.feeds.intervals_feed import readings_of
from ddh_twin_py.nodes.messages.named import ordered
from ddh_twin_py.physics.thermal_network import FLOW_PATHS, MOTOR_NODES, N, N_FLOWS, NODES
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.telemetry.ticks import Tick, tick_index
from ddh_twin_py.twin.operating_point import PresentDuty, measured_rows

STATE_TOPIC = "hydraulics/state"
PREDICTION_TOPIC = "hydraulics/prediction"
MOTOR_TOPIC = "motor/thermal_state"

_MOTOR = len(MOTOR_NODES)
_DUTY = ("speed", "pressure_piston_side", "pressure_rod_side", "rod_velocity")
_ASKED = (*_DUTY, "current")
STATE_WIDTH = 2 + N + N_FLOWS + len(_ASKED)  # known, rod position, heat, flow, what a duty is made of, current that the shaft needs
MOTOR_WIDTH = 2 + _MOTOR  # known, mean square current, heat


def state_rows(example: object, values: dict[str, np.ndarray]) -> np.ndarray:
    """Rows (n, STATE_WIDTH) of `HydraulicState`, whatever order its names come in."""
    heat = ordered(example.heat_nodes, NODES, values["heat"], missing=0.0)
    flow = ordered(example.flow_paths, FLOW_PATHS, values["flow"], missing=0.0)
    return np.column_stack([values["telemetry_known"], values["rod_position"], heat, flow, *(values[name] for name in _ASKED)])


def motor_rows(example: object, values: dict[str, np.ndarray]) -> np.ndarray:
    """Rows (n, MOTOR_WIDTH) of `MotorThermalState`."""
    heat = ordered(example.heat_nodes, MOTOR_NODES, values["heat"], missing=0.0)
    return np.column_stack([values["telemetry_known"], values["mean_square_current"], heat])


def node_temperatures(names: Sequence[str], values: np.ndarray) -> np.ndarray:
    """Temperatures (n, N) in the order of the twin's nodes; NaN for a node that was not named."""
    return ordered(names, NODES, values)


def inputs_of(ticks: Sequence[Tick]) -> tuple[FusionInputs, list[Reading]]:
    """What the fusion takes for n ticks: the models' rows, and the readings of the sensors."""
    inputs = FusionInputs.unknown(len(ticks))
    readings: list[Reading] = []
    for i, tick in enumerate(ticks):
        state, motor = tick.samples[STATE_TOPIC], tick.samples[MOTOR_TOPIC]
        if len(state):
            row = state.values[-1]
            inputs.hydraulics_known[i], inputs.rod_position[i] = row[0] > 0.0, row[1]
            inputs.heat[i, _MOTOR:] = row[2 + _MOTOR : 2 + N]
            inputs.flow[i] = row[2 + N : 2 + N + N_FLOWS]
        if len(motor):
            row = motor.values[-1]
            inputs.motor_known[i], inputs.mean_square_current[i] = row[0] > 0.0, row[1]
            inputs.heat[i, :_MOTOR] = row[2:]
        readings += readings_of(tick, i)
    return inputs, readings


def asked_of(ticks: Sequence[Tick]) -> dict[str, np.ndarray]:
    """What the soft sensor says of the shaft of n ticks, see `CurrentWatch.take`, (n,) each, NaN where it says nothing."""
    rows = np.full((len(ticks), len(_ASKED)), np.nan)
    for i, tick in enumerate(ticks):
        if len(state := tick.samples[STATE_TOPIC]):
            rows[i] = state.values[-1][2 + N + N_FLOWS :]
    return dict(zip(_ASKED, rows.T, strict=True))


def add_duty(present: PresentDuty, asked: Mapping[str, np.ndarray], inputs: FusionInputs) -> None:
    """Tell the present duty of ticks that passed and of telemetry that both models knew in them; ``asked``: of all, see `asked_of`."""
    present.passes(inputs.hydraulics_known.size)
    known = np.flatnonzero(inputs.hydraulics_known & inputs.motor_known)
    if known.size:
        values = {name: rows[known] for name, rows in asked.items()} | {
            "rod_position": inputs.rod_position[known], "current_square": inputs.mean_square_current[known],
            "current": np.sqrt(inputs.mean_square_current[known]),
        }
        present.add(inputs.heat[known], inputs.flow[known], inputs.mean_square_current[known], measured_rows(values, known.size))


def late_readings(late: Sequence[tuple[str, int, Sequence[float]]], start_ns: int, interval_ns: int) -> list[Reading]:
    """Temperature samples of intervals that were done before the one that starts at ``start_ns``: indices below 0."""
    return [
        Reading(tick_index(stamp, interval_ns) - 1 - start_ns // interval_ns, topic.removeprefix(TEMPERATURE_PREFIX), float(row[0]))
        for topic, stamp, row in late
    ]
