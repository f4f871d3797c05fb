"""A bag with the twin's outputs beside the recording: the topics of the live nodes, filled by a replay."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from ddh_twin_py.bags.message_types import know
from ddh_twin_py.bags.qos import LATCHED, RELIABLE, SENSOR_DATA
from ddh_twin_py.bags.topics import split_topic
from ddh_twin_py.bags.writer import BagWriter, whole_bag
from ddh_twin_py.estimation.replay_result import ReplayResult
from ddh_twin_py.exchange.bulk_messages import BulkMessages, Numbers
from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.physics.balance import OPERATING_FIELDS
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.sources.raw_bag import RawBag
from ddh_twin_py.telemetry.signals import RIG_TOPIC, ZERO_CELSIUS
from ddh_twin_py.twin.hydraulic_model import RESIDUAL_SIGNALS
from ddh_twin_py.twin.losses import LOSSES

_BLOCK = 2000  # intervals composed at once
_TEMPERATURE = "sensor_msgs/msg/Temperature"


def write_output_bag(
    target: str | Path, source: str | Path, result: ReplayResult, progress: Callable[[float], None] | None = None,
) -> list[str]:
    """Write a rosbag2 folder (MCAP) with every message of a recording, and with the twin's outputs as the live nodes publish them.

    In the namespace of the rig: `temperature/estimates`, `estimate/<location>` and, where the replay was smoothed,
    `smoothed/<location>` (`sensor_msgs/Temperature` with variance), `hydraulics/state` (soft sensor), `hydraulics/prediction`
    (free run) and `hydraulics/residuals` of both. Heat and flows by node are left empty; a replay does not keep them.
    An output is logged where its interval ends, a message of the recording where it was logged.

    Args:
        target: folder to write, must not exist. source: the bag that was replayed. result: its replay.

    Returns:
        topics of the recording that were left out, because the definition of their type is nowhere.

    Raises:
        BagError: the bag cannot be read, or the target not be written.
        ExchangeError: the definitions of the twin's own messages are nowhere.
    """
    try:
        outputs = _outputs(result)
    except KeyError as error:
        raise ExchangeError(f"{target}: the twin's messages cannot be written: {error.args[0]}") from None
    with closing(RawBag(source)) as raw:
        left_out = [topic for topic, kind in raw.topics if not _defined(kind)]
        kept_out = {f"{result.recording.namespace}/{topic}" for topic, _, _ in outputs} | set(left_out)  # an earlier twin gives way
        with whole_bag(target) as writer:
            done = 0
            waiting = _blocks(result, outputs)
            ahead = next(waiting, None)
            for block in raw.blocks():
                for number, log_time, message in zip(block.topic.tolist(), block.log_time.tolist(), block.messages, strict=True):
                    while ahead is not None and ahead[0] <= log_time:
                        _put(writer, result, ahead)
                        ahead = next(waiting, None)
                    topic, kind = raw.topics[number]
                    if topic not in kept_out:
                        writer.write_raw(topic, kind, _qos(topic), log_time, message)
                done += len(block.messages)
                if progress is not None:
                    progress(done / raw.count)
            while ahead is not None:
                _put(writer, result, ahead)
                ahead = next(waiting, None)
    return left_out


_Output = tuple[str, BulkMessages, Callable[[slice], tuple[np.ndarray, Mapping[str, np.ndarray]]]]


def _outputs(result: ReplayResult) -> list[_Output]:
    """Topic, layout, and what gives rows and values of intervals."""
    celsius = result.fused - ZERO_CELSIUS
    measured, age = _last_readings(result)
    free = result.free_temperature - ZERO_CELSIUS
    air = result.ambient - ZERO_CELSIUS if result.ambient.size else np.full(result.time.size, np.nan)
    every = np.arange(result.time.size)
    points = [name for name in OPERATING_FIELDS if name in _state_layout("", 0).names]

    def estimates(rows):
        return every[rows], {
            "ambient": air[rows], "estimates.temperature": celsius[rows], "estimates.standard_deviation": result.fused_std[rows],
            "estimates.predicted": free[rows], "estimates.measured": measured[rows], "estimates.measured_age": age[rows],
        }

    def state(of, temperature):
        def values(rows):
            found = {name: of[name][rows] for name in points}
            found["losses.power"] = np.column_stack([sum(of[f][rows] for f in fields) for fields in LOSSES.values()])
            found |= {"interval": interval, "telemetry_known": _known(result)[rows]}
            return every[rows], found | ({"temperature": temperature[rows]} if temperature is not None else {})
        return values

    def residuals(of):
        read = np.column_stack([result.measured[name] for name, _, _ in RESIDUAL_SIGNALS])
        said = np.column_stack([of[name] for name, _, _ in RESIDUAL_SIGNALS])
        noise = np.array([[result.rig.sensors[key].noise for _, key, _ in RESIDUAL_SIGNALS]])

        def values(rows):
            return every[rows], {
                "residuals.measured": read[rows], "residuals.predicted": said[rows], "residuals.residual": (read - said)[rows],
                "residuals.standard_deviation": np.broadcast_to(noise, read[rows].shape),
            }
        return values

    interval = float(np.median(np.diff(result.time))) if result.time.size > 1 else 0.0
    found: list[_Output] = [
        ("temperature/estimates", BulkMessages("ddh_msgs/msg/TemperatureEstimateArray", "ddh",
                                               {"estimates": [{"location": node} for node in NODES]}), estimates),
        ("hydraulics/state", _state_layout("soft_sensor", 0), state(result.soft, None)),
        ("hydraulics/prediction", _state_layout("free_run", len(NODES)), state(result.free, free)),
    ]
    rows_of = [{"signal": name, "unit": unit} for name, _, unit in RESIDUAL_SIGNALS]
    for mode, of in (("soft_sensor", result.soft), ("free_run", result.free)):
        layout = BulkMessages("ddh_msgs/msg/ResidualArray", "ddh", {"source": mode, "residuals": rows_of})
        found.append(("hydraulics/residuals", layout, residuals(of)))
    for i, node in enumerate(NODES):
        found.append((f"estimate/{node}", BulkMessages(_TEMPERATURE, node), _temperatures(every, celsius[:, i], result.fused_std[:, i])))
        if result.smoothed_row.size:
            found.append((f"smoothed/{node}", BulkMessages(_TEMPERATURE, node),
                          _temperatures(result.smoothed_row, result.smoothed[:, i] - ZERO_CELSIUS, result.smoothed_std[:, i])))
    return found


def _temperatures(index: np.ndarray, celsius: np.ndarray, deviation: np.ndarray):
    """Values of `sensor_msgs/Temperature` in those intervals of a slice in which there are some."""
    def values(rows):
        chosen = slice(*np.searchsorted(index, (rows.start, rows.stop)))
        return index[chosen], {"temperature": celsius[chosen], "variance": deviation[chosen] ** 2}
    return values


def _state_layout(mode: str, temperatures: int) -> BulkMessages:
    return BulkMessages("ddh_msgs/msg/HydraulicState", "ddh", {
        "mode": mode, "losses": [{"component": name} for name in LOSSES], "heat_nodes": [], "heat": np.empty(0), "flow_paths": [],
        "flow": np.empty(0), "temperature_nodes": list(NODES[:temperatures]),
        "temperature": Numbers(temperatures) if temperatures else np.empty(0),
    })


def _last_readings(result: ReplayResult) -> tuple[np.ndarray, np.ndarray]:
    """Last accepted reading of each node, degC, and its age in s, (n, N); NaN where there is none."""
    n = result.time.size
    value, row = np.full((n, len(NODES)), np.nan), np.full((n, len(NODES)), -1)
    places = {found.node: NODES.index(found.node) for found in result.sensors.values()}
    node_of = {sensor: places[found.node] for sensor, found in result.sensors.items()}
    for innovation in result.innovations:
        if innovation.accepted and 0 <= innovation.index < n:
            value[innovation.index, node_of[innovation.sensor]] = innovation.measured - ZERO_CELSIUS
            row[innovation.index, node_of[innovation.sensor]] = innovation.index
    last = np.maximum.accumulate(row, axis=0)
    there = last >= 0
    value = np.where(there, np.take_along_axis(value, np.maximum(last, 0), axis=0), np.nan)
    age = np.where(there, result.time[:, None] - result.time[np.maximum(last, 0)], np.nan)
    return value, age


def _known(result: ReplayResult) -> np.ndarray:
    return np.all([np.isfinite(result.measured[name]) for name in ("speed", "current", "pressure_piston_side", "rod_position")], axis=0)


def _blocks(result: ReplayResult, outputs: Sequence[_Output]) -> Iterator[tuple[int, str, str, bytes]]:
    """Log time, topic, type and message of all outputs, in order of intervals."""
    stamps = np.rint(result.time * 1e9).astype(np.int64) + np.int64(result.recording.epoch_ns)
    logged = np.maximum.accumulate(stamps)  # a recorder's clock never runs backwards
    for start in range(0, stamps.size, _BLOCK):
        made = []
        for topic, layout, values in outputs:
            index, told = values(slice(start, min(stamps.size, start + _BLOCK)))
            messages = layout.compose(stamps[index], told)
            made += [(i, topic, layout.message_type, message) for i, message in zip(index.tolist(), messages, strict=True)]
        made.sort(key=lambda entry: entry[0])
        for i, topic, kind, message in made:
            yield int(logged[i]), topic, kind, message


def _defined(message_type: str) -> bool:
    try:
        know(message_type)
    except KeyError:
        return False
    return True


def _put(writer: BagWriter, result: ReplayResult, output: tuple[int, str, str, bytes]) -> None:
    log_time, topic, kind, message = output
    writer.write_raw(f"{result.recording.namespace}/{topic}", kind, RELIABLE, log_time, message)


def _qos(topic: str):
    split = split_topic(topic)
    return RELIABLE if split is None else LATCHED if split[1] == RIG_TOPIC else SENSOR_DATA
