"""What a replay makes of a recording: models, fused temperatures and every sensor beside them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.estimation.doubts.out_of_place import OutOfPlace
from ddh_twin_py.estimation.fusion.result import Innovation
from ddh_twin_py.estimation.fusion.uncertain_parameters import N_UNKNOWN_HEATS
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording


@dataclass(frozen=True)
class SensorComparison:
    """One temperature sensor against the twin.

    Attributes:
        node: thermal node that it reads. time: s, (m,). measured: K, less what the rig file says that it reads of the air, (m,).
        predicted: K, the free run seen through the sensor's lag, (m,).
        fused: K, the estimate seen through the lag, (m,). fused_std: K, of the node, (m,).
        noise: K. used: whether the fusion was given this sensor.
        row: interval of each reading, (m,).
    """

    node: str
    time: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray
    fused: np.ndarray
    fused_std: np.ndarray
    noise: float
    used: bool
    row: np.ndarray


@dataclass(frozen=True)
class ReplayResult:
    """What the twin makes of a recording, on intervals that end at ``time``.

    Attributes:
        time: s from the recording's epoch, (n,). measured: `MEASURED_DTYPE`, (n,).
        soft, free: operating points of soft sensor and free run, `balance.SCALAR_DTYPE`, (n,).
        free_temperature, fused, fused_std: K, (n, N), order `thermal_network.NODES`.
        sensors: by name. innovations: every reading that the filter met.
        seconds: computing time of each stage.
        smoothed_row: intervals of the smoothed temperatures, (k,), none unless asked for.
        smoothed, smoothed_std: K, from the readings before and after, (k, N).
        smoothed_heat, smoothed_heat_std: W, unknown heats alike, (k, N_UNKNOWN_HEATS), see `uncertain_parameters.UNKNOWN_HEATS`.
        covariance: K^2, of the fused temperatures at ``smoothed_row``, (k, N, N), none unless asked for.
        ambient: K, what the models took for the air, (n,); empty where nobody said.
        sampled_at: by topic of telemetry, s, mean time of each interval's samples, (n,), NaN where none came.
        off: where the free run lost its command and the machine moved on, (n,). settled: see `HydraulicResult`, (n,). Both empty where
            nobody said.
        zero_error: the sensor whose zero the filter holds farthest off at the end, by how many standard deviations, and K; None where it
            did not run.
        left_out: sensors that a first run told to be out of place, and that the fusion was not given again.
    """

    recording: Recording
    rig: Rig
    time: np.ndarray
    measured: np.ndarray
    soft: np.ndarray
    free: np.ndarray
    free_temperature: np.ndarray
    fused: np.ndarray
    fused_std: np.ndarray
    sensors: dict[str, SensorComparison]
    innovations: list[Innovation]
    seconds: dict[str, float]
    smoothed_row: np.ndarray = field(default_factory=lambda: np.empty(0, np.int64))
    smoothed: np.ndarray = field(default_factory=lambda: np.empty((0, N)))
    smoothed_std: np.ndarray = field(default_factory=lambda: np.empty((0, N)))
    smoothed_heat: np.ndarray = field(default_factory=lambda: np.empty((0, N_UNKNOWN_HEATS)))
    smoothed_heat_std: np.ndarray = field(default_factory=lambda: np.empty((0, N_UNKNOWN_HEATS)))
    covariance: np.ndarray = field(default_factory=lambda: np.empty((0, N, N)))
    ambient: np.ndarray = field(default_factory=lambda: np.empty(0))
    sampled_at: Mapping[str, np.ndarray] = field(default_factory=dict)
    off: np.ndarray = field(default_factory=lambda: np.empty(0, bool))
    settled: np.ndarray = field(default_factory=lambda: np.empty(0, bool))
    zero_error: tuple[str, float, float] | None = None
    left_out: tuple[OutOfPlace, ...] = ()

    def free_where_sampled(self, name: str, topic: str) -> np.ndarray:
        """The free run at the mean time of each interval's samples, (n,), NaN where none came.

        Samples of a slow stream need not lie about the middle of an interval, for which its mean stands.
        """
        values = self.free[name]
        if topic not in self.sampled_at or self.time.size < 2:
            return values
        step = np.diff(self.time)
        interval = float(np.median(step))
        change = np.where(np.abs(step - interval) < 0.5 * interval, np.diff(values), np.nan)  # not across a jump of the clock
        before, after = np.concatenate([[np.nan], change]), np.concatenate([change, [np.nan]])
        before, after = np.where(np.isnan(before), after, before), np.where(np.isnan(after), before, after)
        off = (self.sampled_at[topic] - self.time) / interval + 0.5
        return values + off * np.nan_to_num(np.where(off < 0.0, before, after))
