"""How hot it will get and when: node temperatures ahead, time to each limit, the duty that keeps it.

The filter's mean, and draws from its covariance (temperatures, parameters, unknown heats), are run
ahead with the one thermal network under the means of a duty. The winding's hottest point lies above
the mean of its lumped node by a share of its rise over the air:

    T_hot = T_w + f (T_w - T_ambient),   f = 0.095 +- 0.05

so that 105 K of rise by resistance have the 10 K of hot-spot allowance that IEC 60034-1 (table of
temperature rise) leaves between class F's 40 + 105 degC and its 155 degC (IEC 60085).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import bisect, brentq

from ddh_twin_py.estimation.fusion.state import FusionState
from ddh_twin_py.estimation.fusion.temperature_filter import predict_mean
from ddh_twin_py.estimation.fusion.uncertain_parameters import (
    N_UNCERTAIN,
    N_UNKNOWN_HEATS,
    UNKNOWN_HEAT_AT,
    UNKNOWN_HEAT_STD,
    UNKNOWN_HEAT_TIME,
)
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.physics.motor import CUT_BACK_FROM, CUT_OFF_AT
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import END_WINDING, N, NODES, SLOT_WINDING, copper_loss
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.operating_point import OperatingPoint, ScaledDuty
from ddh_twin_py.twin.sensor_errors import sensor_lags

HOT_SPOT_SHARE, HOT_SPOT_SPREAD = 0.095, 0.05
DRAWS = 48
STEPS = 48
_SETTLING_STEPS = 28
_HOTTEST = CUT_OFF_AT + 100.0
"""K; the drive gives no current to a winding beyond `CUT_OFF_AT`, so that hotter ones are those of a step too long."""
SETTLED = 10 * 86400.0
"""s after which a unit counts as settled."""
_FIRST_STEP = 1.0  # s
_SHORTEST, _LEAP = 0.2, 5.0  # s; K by which one step may leap over the cut-back
_M = len(SENSORS)
_WINDINGS = np.array([i for i, name in enumerate(NODES) if "winding" in name])

HOT_SPOT = "winding_hot_spot"
LOCATIONS = {
    HOT_SPOT: _WINDINGS,
    "oil": np.array([i for i, name in enumerate(NODES) if "_oil" in name]),
    "seals": np.array([i for i, name in enumerate(NODES) if name.endswith(("_case", "_barrel"))]),
}
"""What has a limit, and the nodes of which the hottest counts."""


@dataclass(frozen=True)
class LimitForecast:
    """One limit under one duty; temperatures in K, times in s (inf: not within the horizon).

    Attributes:
        temperature, standard_deviation: now. at_horizon: expected at its end. time: expected.
        time_16, time_84: quantiles. probability: that it is exceeded within the horizon.
        allowed_current: A rms. allowed_speed: rad/s, mean absolute, NaN where the duty has none.
        reached_at_rest: whether rest from now on does not prevent it.
    """

    location: str
    limit: float
    temperature: float
    standard_deviation: float
    at_horizon: float
    time: float
    time_16: float
    time_84: float
    probability: float
    allowed_current: float
    allowed_speed: float
    reached_at_rest: bool


@dataclass(frozen=True)
class Forecast:
    """Temperatures ahead and what they mean.

    Attributes:
        time: s from now, (k,). temperature, standard_deviation: K, (k, N + 1), the winding's hot spot last.
        limits: one for each limit.
    """

    time: np.ndarray
    temperature: np.ndarray
    standard_deviation: np.ndarray
    limits: list[LimitForecast]


@dataclass(frozen=True)
class Span:
    """A duty until a time, s from now."""

    end: float
    point: OperatingPoint


class LookAhead:
    """Looks ahead from the state of a filter.

    Args:
        rig: the rig, as the filter's. limits: K by location of `LOCATIONS`.
    """

    def __init__(self, rig: Rig, limits: dict[str, float]) -> None:
        self._parameters = rig.parameters
        self._lag = sensor_lags(rig)
        self._node = np.array([NODE_INDEX[sensor] for sensor in SENSORS])
        self._current_limit = rig["motor.current_limit"]
        self.limits = limits
        rng = np.random.default_rng(20)
        half = rng.standard_normal((DRAWS // 2, N + _M + N_UNCERTAIN + 1))
        self._normal = np.concatenate([half, -half])  # in pairs, so that their mean is the filter's
        half = rng.standard_normal((DRAWS // 2, STEPS, N_UNKNOWN_HEATS))
        self._wander = np.concatenate([half, -half])

    def forecast(self, state: FusionState, schedule: Sequence[Span], horizon: float, scaled: ScaledDuty | None = None) -> Forecast:
        """Under a schedule of duties (the last one goes on) over ``horizon`` s; ``scaled`` is the duty at other speeds."""
        times = step_times(horizon)
        mean = self._run(state, schedule, times)
        drawn = self._drawn(state, schedule, times)
        share = np.maximum(HOT_SPOT_SHARE + HOT_SPOT_SPREAD * self._normal[:, -1], 0.0)
        mean_all = with_hot_spot(mean, state.ambient, HOT_SPOT_SHARE)
        drawn_all = with_hot_spot(drawn, state.ambient, share[:, None])
        rest = with_hot_spot(self._run(state, [Span(horizon, OperatingPoint.rest(schedule[0].point.position))], times), state.ambient,
                             HOT_SPOT_SHARE)
        last = schedule[-1].point
        rows = []
        for location, limit in self.limits.items():
            at = np.array([N]) if location == HOT_SPOT else LOCATIONS[location]
            path, paths = mean_all[:, at].max(axis=1), drawn_all[:, :, at].max(axis=2)
            reached = np.sort([crossing(times, p, limit) for p in paths])
            now, deviation = float(path[0]), float(np.std(paths[:, 0]))
            if location == HOT_SPOT:
                told = hot_spot(state.dynamic[None, :N], np.sqrt(np.diagonal(state.covariance)[None, :N]), state.ambient)
                now, deviation = float(told[0][0]), float(told[1][0])
            rows.append(LimitForecast(
                location, limit, now, deviation, float(path[-1]), crossing(times, path, limit),
                float(reached[round(0.16 * (DRAWS - 1))]), float(reached[round(0.84 * (DRAWS - 1))]),
                float(np.isfinite(reached).mean()), self._allowed_current(state, last, at, limit),
                self._allowed_speed(state, scaled, at, limit), bool(rest[:, at].max() >= limit),
            ))
        return Forecast(times, mean_all, drawn_all.std(axis=0), rows)

    def mean_temperatures(self, state: FusionState, schedule: Sequence[Span], times: np.ndarray) -> np.ndarray:
        """Node temperatures at ``times``, K, (k, N), of the filter's mean."""
        return self._run(state, schedule, times)

    def settled_temperatures(self, state: FusionState, point: OperatingPoint) -> np.ndarray:
        """Node temperatures after `SETTLED` seconds of one duty, K, (N,); those at the cut-back where it leads there."""
        return self._run(state, [Span(SETTLED, point)], _SETTLING)[-1]

    def _run(self, state: FusionState, schedule: Sequence[Span], times: np.ndarray) -> np.ndarray:
        still = np.zeros((1, len(times), N_UNKNOWN_HEATS))
        return self._ahead(state.dynamic[None], state.deviation[None], state.ambient, schedule, times, still)[0]

    def _drawn(self, state: FusionState, schedule: Sequence[Span], times: np.ndarray) -> np.ndarray:
        d = N + _M
        index = np.concatenate([np.arange(d), np.arange(d + _M, d + _M + N_UNCERTAIN)])
        moved = self._normal[:, :-1] @ square_root(state.covariance[np.ix_(index, index)]).T
        dynamic = state.dynamic + moved[:, :d]
        deviation = state.deviation + moved[:, d:]
        relative = np.r_[0: UNKNOWN_HEAT_AT]
        deviation[:, relative] = np.maximum(deviation[:, relative], -0.9)
        return self._ahead(dynamic, deviation, state.ambient, schedule, times, self._wander)

    def _ahead(self, dynamic, deviation, ambient, schedule, times, wander) -> np.ndarray:
        ends = np.array([span.end for span in schedule[:-1]])
        which = np.searchsorted(ends, times[1:] - 1e-9)
        points = [span.point for span in schedule]
        out = np.empty((len(dynamic), len(times), N))
        run_ahead(
            self._parameters, np.array(dynamic), np.array(deviation), self._node, self._lag,
            np.array([p.heat for p in points]), np.array([p.mean_square_current for p in points]), np.array([p.flow for p in points]),
            np.array([p.position for p in points]), which, ambient, times, wander, out,
        )
        return out

    def _settled(self, state: FusionState, point: OperatingPoint, at: np.ndarray) -> float:
        """Hottest of the nodes once settled, K; unknown heats are forgotten by then."""
        path = self._run(state, [Span(SETTLED, point)], _SETTLING)
        hottest = with_hot_spot(path, state.ambient, HOT_SPOT_SHARE)[:, at].max(axis=1)
        # where the drive cuts back there is nothing to settle at, the copper loss runs away
        return float(hottest.max() if hottest.max() >= CUT_BACK_FROM > hottest[0] else hottest[-1])

    def _allowed_current(self, state: FusionState, point: OperatingPoint, at: np.ndarray, limit: float) -> float:
        return largest(lambda rms: self._settled(state, point.with_current(rms), at) - limit, self._current_limit)

    def _allowed_speed(self, state: FusionState, scaled: ScaledDuty | None, at: np.ndarray, limit: float) -> float:
        if scaled is None:
            return float("nan")
        return scaled.at(largest(lambda scale: self._settled(state, scaled.at(scale), at) - limit, scaled.largest)).speed


def square_root(covariance: np.ndarray) -> np.ndarray:
    """A matrix R with R R^T = covariance (n, n), which may be singular."""
    scale = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    scale[scale == 0.0] = 1.0
    correlation = covariance / np.outer(scale, scale)
    try:
        return scale[:, None] * np.linalg.cholesky(correlation + 1e-9 * np.eye(len(scale)))
    except np.linalg.LinAlgError:
        value, vector = np.linalg.eigh(correlation)
        return scale[:, None] * vector * np.sqrt(np.maximum(value, 0.0))


def step_times(horizon: float, steps: int = STEPS) -> np.ndarray:
    """0 and the ends of growing steps up to ``horizon``, s, (steps + 1,)."""
    even = np.linspace(0.0, 1.0, steps + 1)
    if horizon <= steps * _FIRST_STEP:
        return horizon * even
    growth = brentq(lambda g: _FIRST_STEP * np.expm1(steps * np.log1p(g)) / g - horizon, 1e-9, 10.0)
    times = _FIRST_STEP * np.expm1(np.arange(steps + 1) * np.log1p(growth)) / growth
    times[-1] = horizon
    return times


_SETTLING = step_times(SETTLED, _SETTLING_STEPS)


def hot_spot(temperature: np.ndarray, deviation: np.ndarray, ambient: float) -> tuple[np.ndarray, np.ndarray]:
    """The winding's hottest point and its standard deviation, K, (n,), from the nodes' (n, N)."""
    hottest = _WINDINGS[np.argmax(temperature[:, _WINDINGS], axis=1)]
    row = np.arange(len(temperature))
    rise = np.maximum(temperature[row, hottest] - ambient, 0.0)
    spread = np.hypot((1.0 + HOT_SPOT_SHARE) * deviation[row, hottest], HOT_SPOT_SPREAD * rise)
    return temperature[row, hottest] + HOT_SPOT_SHARE * rise, spread


def with_hot_spot(temperature: np.ndarray, ambient: float, share: float | np.ndarray) -> np.ndarray:
    """Node temperatures (..., N) with the winding's hottest point added, (..., N + 1)."""
    hottest = temperature[..., _WINDINGS].max(axis=-1)
    return np.concatenate([temperature, (hottest + share * np.maximum(hottest - ambient, 0.0))[..., None]], axis=-1)


def crossing(times: np.ndarray, path: np.ndarray, limit: float) -> float:
    """When a path first reaches a limit, linear between its points; inf where it does not."""
    above = np.flatnonzero(path >= limit)
    if not above.size:
        return float("inf")
    k = above[0]
    if k == 0:
        return 0.0
    return float(times[k - 1] + (times[k] - times[k - 1]) * (limit - path[k - 1]) / (path[k] - path[k - 1]))


def largest(excess: Callable[[float], float], most: float) -> float:
    """Largest value up to ``most`` whose excess is not above 0, excess rising with it; 0 where none is."""

    def known(value: float) -> float:
        found = excess(value)
        return found if np.isfinite(found) else float("inf")

    if known(most) <= 0.0:
        return most
    if not known(0.0) < 0.0:
        return 0.0
    width = 5e-4 * most
    return max(float(bisect(lambda value: min(known(value), 1e6), 0.0, most, xtol=width)) - width, 0.0)


def default_limits(rig: Rig) -> dict[str, float]:
    """K by location: the winding's from the sheet, 80 degC of oil (ISO VG 32 has thinned to 8.5 mm2/s and ages twice as
    fast per 10 K above it), 100 degC of NBR seals."""
    return {HOT_SPOT: ZERO_CELSIUS + rig["motor.thermal.winding_limit"], "oil": ZERO_CELSIUS + 80.0, "seals": ZERO_CELSIUS + 100.0}


@kernel
def _longest_step(params, dynamic, square):
    """s over which the copper's loss, which grows with its own heat, may be taken in one step and not leap over the cut-back."""
    p = params[0]
    share = p.motor_end_winding_copper_share
    slot, end = copper_loss(dynamic[:N], square, p)
    rate = max(slot / p.motor_slot_winding_capacity, end / p.motor_end_winding_capacity)
    growth = 3.0 * p.motor_phase_resistance_20C * square * p.motor_copper_temperature_coefficient * max(
        (1.0 - share) / p.motor_slot_winding_capacity, share / p.motor_end_winding_capacity)
    room = max(CUT_BACK_FROM - max(dynamic[SLOT_WINDING], dynamic[END_WINDING]), 0.0) + _LEAP
    return max(_SHORTEST, min(room / max(rate, 1e-9), 0.5 / max(growth, 1e-12)))


@kernel
def run_ahead(params, dynamic, deviation, node, lag, heat, square, flow, position, which, ambient, times, wander, out):
    """Run draws (n, N + m), (n, N_UNCERTAIN) ahead, in place; fill temperatures (n, k, N) at ``times`` (k,).

    Args:
        heat (p, N), square (p,), flow (p, N_FLOWS), position (p,): of the duties. which: duty of each step, (k - 1,).
        A draw whose winding reaches the drive's cut-back stays as it is from there on.
        wander: standard normal, drives the unknown heats, (n, k - 1 or more, N_UNKNOWN_HEATS); zeros let them decay.
    """
    work = np.empty((N + 3, N))
    for r in range(dynamic.shape[0]):
        out[r, 0] = dynamic[r, :N]
        tripped = False
        for k in range(times.shape[0] - 1):
            step, d = times[k + 1] - times[k], which[k]
            left = step
            while left > 0.0 and not tripped:
                part = min(left, _longest_step(params, dynamic[r], square[d]))
                predict_mean(params, dynamic[r], deviation[r], node, lag, heat[d], square[d], flow[d], position[d], ambient, part, work)
                left -= part
                tripped = not max(dynamic[r, SLOT_WINDING], dynamic[r, END_WINDING]) < CUT_BACK_FROM
            if tripped:  # the drive takes the current back from here on, the duty cannot go on
                for i in range(N):
                    dynamic[r, i] = min(dynamic[r, i], _HOTTEST) if dynamic[r, i] == dynamic[r, i] else out[r, k, i]
                    out[r, k + 1:, i] = dynamic[r, i]
                break
            fresh = np.sqrt(1.0 - np.exp(-2.0 * step / UNKNOWN_HEAT_TIME))
            for j in range(N_UNKNOWN_HEATS):
                deviation[r, UNKNOWN_HEAT_AT + j] += fresh * UNKNOWN_HEAT_STD[j] * wander[r, k, j]
            for i in range(N):
                out[r, k + 1, i] = min(dynamic[r, i], _HOTTEST)
                dynamic[r, i] = out[r, k + 1, i]
