"""What the live nodes published, as a replay result: read back from the bag that they were recorded in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ddh_msgs.msg import HydraulicState, MotorThermalState, ResidualArray, TemperatureEstimateArray
from ddh_twin_py.cli.arguments import InputError
from ddh_twin_py.estimation.fusion.result import Innovation
from ddh_twin_py.estimation.fusion.temperature_filter import GATE
from ddh_twin_py.estimation.replay_result import ReplayResult
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.nodes.messages.conversion import FREE_RUN, FUSION, SOFT_SENSOR, to_kelvin
from ddh_twin_py.nodes.messages.wire import BulkParser
from ddh_twin_py.physics.balance import OPERATING_DTYPE, OPERATING_FIELDS
from ddh_twin_py.physics.thermal_network import NODES, ROTOR, TEETH, YOKE
from ddh_twin_py.sources.raw_bag import RawBag
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.twin.lagged_readings import lagged
from ddh_twin_py.twin.losses import LOSSES
from ddh_twin_py.twin.sensor_errors import sensor_lags, temperature_zero_errors
from ddh_twin_py.twin.temperature_sensors import sensed

_TYPES = {
    f"ddh_msgs/msg/{kind.__name__}": kind
    for kind in (HydraulicState, MotorThermalState, ResidualArray, TemperatureEstimateArray)
}


@dataclass(frozen=True)
class _Series:
    stamps: np.ndarray
    values: Mapping[str, np.ndarray]
    example: object


def live_result(bag: str | Path, offline: ReplayResult) -> tuple[ReplayResult, float]:
    """The replay result with the twin's values as they came over the topics, and the share of intervals that came.

    Args:
        bag: with the outputs of the nodes. offline: replay of the same telemetry in one process;
            gives what was measured, and the intervals.

    Raises:
        InputError: where an output is missing altogether.
    """
    series = _read(bag)
    for key in (SOFT_SENSOR, FREE_RUN, "estimates"):
        if key not in series:
            raise InputError(f"{bag}: no {key.replace('_', ' ')} was recorded; the live nodes published nothing of it")
    stamps = np.rint(offline.time * 1e9).astype(np.int64) + offline.recording.epoch_ns
    soft = _points(series[SOFT_SENSOR], stamps)
    free = _points(series[FREE_RUN], stamps)
    estimates = series["estimates"]
    order = [[e.location for e in estimates.example.estimates].index(node) for node in NODES]
    fused, std, predicted = (
        _at(stamps, estimates.stamps, estimates.values[f"estimates.{name}"][:, order])
        for name in ("temperature", "standard_deviation", "predicted")
    )
    fused, predicted = to_kelvin(fused), to_kelvin(predicted)
    result = replace(
        offline, soft=soft, free=free, free_temperature=predicted, fused=fused, fused_std=std, seconds={},
        innovations=_innovations(series.get(FUSION), stamps),
        sensors=_sensors(offline, fused, std, predicted),
    )
    came = np.isfinite(fused[:, 0]) & np.isfinite(soft["speed"]) & np.isfinite(free["speed"])
    return result, float(came.mean())


def _read(bag: str | Path) -> dict[str, _Series]:
    """Outputs by mode or source: `soft_sensor`, `free_run`, `motor`, `fusion`, `estimates`."""
    raw = RawBag(bag)
    messages: dict[int, list[bytes]] = {}
    try:
        wanted = {number for number, (_, kind) in enumerate(raw.topics) if kind in _TYPES}
        for block in raw.blocks():
            for topic, message in zip(block.topic.tolist(), block.messages, strict=True):
                if topic in wanted:
                    messages.setdefault(topic, []).append(message)
    finally:
        raw.close()
    runs: dict[str, list[tuple[object, np.ndarray, dict[str, np.ndarray]]]] = {}
    for topic, content in messages.items():
        kind = _TYPES[raw.topics[topic][1]]
        for example, stamps, values in BulkParser(kind).parse(content):
            runs.setdefault(_key(example), []).append((example, stamps, values))
    return {
        key: _Series(
            np.concatenate([stamps for _, stamps, _ in parts]),
            {name: np.concatenate([values[name] for _, _, values in parts]) for name in parts[0][2]},
            parts[0][0],
        )
        for key, parts in runs.items()
    }


def _key(example: object) -> str:
    """Under which name a message is kept."""
    if isinstance(example, HydraulicState):
        return example.mode
    if isinstance(example, ResidualArray):
        return example.source if example.source == FUSION else f"residuals of {example.source}"
    return "estimates" if isinstance(example, TemperatureEstimateArray) else "motor"


def _at(stamps: np.ndarray, own: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values at the wanted stamps, NaN where nothing came."""
    order = np.argsort(own, kind="stable")
    place = np.clip(np.searchsorted(own[order], stamps), 0, own.size - 1)
    here = own[order][place] == stamps
    out = np.full((stamps.size, *values.shape[1:]), np.nan)
    out[here] = values[order][place[here]]
    return out


def _points(series: _Series, stamps: np.ndarray) -> np.ndarray:
    """Operating points of the messages of one mode; what they do not carry is NaN."""
    points = np.zeros(stamps.size, OPERATING_DTYPE)
    for name in OPERATING_FIELDS:
        points[name] = _at(stamps, series.stamps, series.values[name]) if name in series.values else np.nan
    heat = _at(stamps, series.stamps, series.values["heat"])
    points["heat"] = heat[:, [list(series.example.heat_nodes).index(node) for node in NODES]]
    points["flow"] = _at(stamps, series.stamps, series.values["flow"])
    losses = _at(stamps, series.stamps, series.values["losses.power"])
    column = {entry.component: i for i, entry in enumerate(series.example.losses)}
    for component, fields in LOSSES.items():
        if len(fields) == 1:
            points[fields[0]] = losses[:, column[component]]
    # the message gives the motor's loss as a whole and the heat of its nodes without copper
    points["loss_iron"] = points["heat"][:, TEETH] + points["heat"][:, YOKE]
    points["loss_motor_friction"] = 2.0 * points["heat"][:, ROTOR]
    points["loss_copper"] = losses[:, column["motor"]] - points["loss_iron"] - points["loss_motor_friction"]
    return points


def _innovations(series: _Series | None, stamps: np.ndarray) -> list[Innovation]:
    if series is None:
        return []
    found = []
    index = np.searchsorted(stamps, series.stamps)
    values = {name: series.values[f"residuals.{name}"] for name in ("measured", "residual", "standard_deviation")}
    for j, entry in enumerate(series.example.residuals):
        sensor = entry.signal.removeprefix(TEMPERATURE_PREFIX)
        for i in np.flatnonzero(np.isfinite(values["residual"][:, j])).tolist():
            measured, left, spread = (float(values[name][i, j]) for name in values)
            kelvin = float(to_kelvin(measured))
            found.append(Innovation(int(index[i]), sensor, kelvin, kelvin - left, spread, abs(left) <= GATE * spread))
    return found


def _sensors(offline: ReplayResult, fused: np.ndarray, std: np.ndarray, predicted: np.ndarray) -> dict:
    """Each sensor beside what it would read of the live estimate: through its lag, and with what is known of its zero."""
    interval, top = float(np.median(np.diff(offline.time))), offline.rig["tank.top_share"]
    lags = dict(zip(SENSORS, sensor_lags(offline.rig), strict=True))
    zeros = dict(zip(SENSORS, temperature_zero_errors(offline.rig)[0].tolist(), strict=True))
    sensors = {}
    for name, c in offline.sensors.items():
        node = NODE_INDEX[name]
        place = np.clip(np.searchsorted(offline.time, c.time), 0, offline.time.size - 1)
        seen = {}
        for key, values in (("predicted", predicted), ("fused", fused)):
            whole = _filled(sensed(values, name, top)[:, None])
            reading = lagged(whole, whole[0], interval, np.array([lags[name]]))[place, 0] + zeros[name]
            seen[key] = np.where(np.isfinite(values[place, node]), reading, np.nan)
        sensors[name] = replace(c, **seen, fused_std=std[place, node])
    return sensors


def _filled(values: np.ndarray) -> np.ndarray:
    """Gaps bridged, so that a filter can run over them."""
    good = np.isfinite(values[:, 0])
    if not good.any():
        return values
    at = np.arange(values.shape[0])
    return np.interp(at, at[good], values[good, 0])[:, None]
