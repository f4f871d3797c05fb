"""The outputs of a replay beside the measurements, as named columns: one value for each interval."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.replay_result import ReplayResult
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.report.replay.agreement import COMPONENTS, FLOOR, INPUTS, component_values, measured_values
from ddh_twin_py.telemetry.signals import DRIVE_SIGNALS, HYDRAULIC_SIGNALS, TEMPERATURE_PREFIX, ZERO_CELSIUS, Signal

BAND = 2.0
"""Standard deviations from an estimate to the edges of its band."""


@dataclass(frozen=True)
class Column:
    """One column: name with slashes as a tree, unit, what it is, values (n,), float64 or int64; NaN where there is none."""

    name: str
    unit: str
    about: str
    values: np.ndarray

    @property
    def heading(self) -> str:
        """Name and unit, as a table's first line has them."""
        return f"{self.name} [{self.unit}]"


def replay_columns(result: ReplayResult) -> list[Column]:
    """All columns of a replay: time, drive and hydraulics, losses, temperatures with their bands.

    A temperature sensor's readings stand in the interval in which they were made and nowhere else.
    """
    stamps = np.rint(result.time * 1e9).astype(np.int64) + np.int64(result.recording.epoch_ns)
    return [
        Column("stamp", "ns", "end of the interval, header stamp, since 1970-01-01 UTC", stamps),
        Column("time", "s", "end of the interval, since the recording's first stamp", result.time),
        *_signals(result),
        *_losses(result),
        *_temperatures(result),
    ]


def _signals(result: ReplayResult) -> Iterator[Column]:
    for signal in (*DRIVE_SIGNALS, *HYDRAULIC_SIGNALS):
        name, unit = signal.name, signal.unit
        if name == "speed_command":
            yield Column(f"{name}/measured", unit, "what the drive was asked for, mean of the interval", result.measured[name])
            continue
        yield Column(f"{name}/measured", unit, f"mean of the interval{_noise(result, signal)}", measured_values(result, signal))
        if name not in INPUTS:
            yield Column(f"{name}/soft_sensor", unit, "from measured pressures, speed, rod motion and current", result.soft[name])
        yield Column(f"{name}/free_run", unit, "from speed command, payload and ambient alone", result.free[name])


def _noise(result: ReplayResult, signal: Signal) -> str:
    noise = result.rig.sensors[signal.noise_key].noise
    return f"; noise of one sample {noise:g} {signal.unit}, noise floor {FLOOR * noise:g} {signal.unit}"


def _losses(result: ReplayResult) -> Iterator[Column]:
    for component, fields in COMPONENTS.items():
        name = "loss/" + component.replace(" ", "_")
        yield Column(f"{name}/soft_sensor", "W", f"heat of {component}, from measurements", component_values(result.soft, fields))
        yield Column(f"{name}/free_run", "W", f"heat of {component}, free run", component_values(result.free, fields))


def _temperatures(result: ReplayResult) -> Iterator[Column]:
    n = result.time.size
    if result.ambient.size == n:
        yield Column("temperature/ambient/used", "degC", "what the models took for the air", result.ambient - ZERO_CELSIUS)
    for sensor, found in result.sensors.items():
        read = np.full(n, np.nan)
        read[found.row] = found.measured - ZERO_CELSIUS
        about = f"reading of temperature/{sensor}, which sits on {found.node}; noise {found.noise:g} K"
        yield Column(f"{TEMPERATURE_PREFIX}{sensor}/measured", "degC", about, read)
    for i, node in enumerate(NODES):
        name, fused, std = f"estimate/{node}", result.fused[:, i] - ZERO_CELSIUS, result.fused_std[:, i]
        free = result.free_temperature[:, i] - ZERO_CELSIUS
        yield Column(f"{name}/temperature", "degC", "fused from models and sensors up to then", fused)
        yield Column(f"{name}/standard_deviation", "K", "of the fused temperature, one sigma", std)
        yield Column(f"{name}/lower", "degC", f"fused less {BAND:g} sigma", fused - BAND * std)
        yield Column(f"{name}/upper", "degC", f"fused plus {BAND:g} sigma", fused + BAND * std)
        yield Column(f"{name}/free_run", "degC", "from speed command, payload and ambient alone", free)
        if result.smoothed_row.size:
            for what, values, unit, about in (
                ("smoothed", result.smoothed[:, i] - ZERO_CELSIUS, "degC", "from the sensors before and after"),
                ("smoothed_standard_deviation", result.smoothed_std[:, i], "K", "of the smoothed temperature, one sigma"),
            ):
                spread = np.full(n, np.nan)
                spread[result.smoothed_row] = values
                yield Column(f"{name}/{what}", unit, about, spread)
