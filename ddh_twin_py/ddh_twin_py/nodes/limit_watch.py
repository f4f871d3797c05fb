"""How far the limits are: topic `temperature/limits`, service `predict_limits`, warnings in `/diagnostics`."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ddh_msgs.msg import LimitPrediction, TemperatureLimit
from ddh_msgs.srv import PredictLimits
from ddh_twin_py.estimation.look_ahead import HOT_SPOT, Forecast, LimitForecast, LookAhead, Span, default_limits, step_times
from ddh_twin_py.estimation.temperature_fusion import FusionState
from ddh_twin_py.nodes import qos
from ddh_twin_py.nodes.conversion import to_celsius, to_kelvin
from ddh_twin_py.nodes.health import Report
from ddh_twin_py.nodes.node_base import TwinNode
from ddh_twin_py.nodes.parameters import Parameter
from ddh_twin_py.physics.thermal_network import N, N_FLOWS, NODES
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.duty import Duty, DutyError, check_for_rig, parse_duty
from ddh_twin_py.twin.operating_point import OperatingPoint, PresentDuty, ScaledDuty, duty_point, measured_rows, scaled_duty

PERIOD = 1.0  # s of wall time
LONGEST_HORIZON = 604800.0  # s
_UNSOLVED = (ValueError, ArithmeticError, np.linalg.LinAlgError)
_REVISIONS = (0.1, 0.3, 0.6, 1.0)  # shares of the horizon at which a given duty is worked out anew at the temperatures reached

LIMIT_PARAMETERS = (
    Parameter(
        "winding_limit", 0.0, "Limit of the winding's hottest point; 0 takes the sheet's motor.thermal.winding_limit. Insulation class F "
        "(IEC 60085) ends at 155 degC.", "degC", 0.0, 240.0,
    ),
    Parameter("oil_limit", 80.0, "Limit of the hottest oil; mineral oil ages twice as fast with each 10 K above.", "degC", 20.0, 150.0),
    Parameter("seal_limit", 100.0, "Limit of pump cases and barrel: NBR seals.", "degC", 20.0, 200.0),
    Parameter("horizon", 3600.0, "How far ahead is looked.", "s", 60.0, LONGEST_HORIZON),
    Parameter("warn_within", 1800.0, "A limit that will be reached within this time is a warning.", "s", 0.0, LONGEST_HORIZON),
)  # fmt: skip


class LimitWatch:
    """Looks ahead once a second of wall time and answers questions; `state` gives the filter's state or None before the first."""

    def __init__(self, node: TwinNode, rig: Rig, state: Callable[[], FusionState | None], stamp_ns: Callable[[], int]) -> None:
        self._node, self._rig, self._state, self._stamp_ns = node, rig, state, stamp_ns
        values = node.values
        limits = default_limits(rig) | {"oil": float(to_kelvin(values["oil_limit"])), "seals": float(to_kelvin(values["seal_limit"]))}
        if values["winding_limit"] > 0.0:
            limits[HOT_SPOT] = float(to_kelvin(values["winding_limit"]))
        self._ahead = LookAhead(rig, limits)
        self._horizon, self._warn_within = values["horizon"], values["warn_within"]
        self.present = PresentDuty(rig, values["interval"])
        self.newest: Forecast | None = None
        self._looked_at = 0
        self._publisher = node.create_publisher(LimitPrediction, "temperature/limits", qos.OUTPUT)
        node.create_service(PredictLimits, "predict_limits", self.answer)
        node.every(PERIOD, self.look)

    def warm_up(self, state: FusionState) -> None:
        """Load or compile now what a look needs, so that no estimate waits for it."""
        present = PresentDuty(self._rig, self._node.values["interval"])
        one = np.ones(1)
        rows = measured_rows({"speed": one, "current": one, "pressure_piston_side": 1e6 * one}, 1)
        present.add(np.zeros((1, N)), np.zeros((1, N_FLOWS)), one, rows)
        scaled = present.scaled(np.ascontiguousarray(state.dynamic[:N]))
        self._ahead.forecast(state, [Span(60.0, present.point())], 60.0, scaled)

    def look(self) -> None:
        """Publish how the limits stand, where there is a new estimate."""
        state, stamp = self._state(), self._stamp_ns()
        if state is None or stamp == self._looked_at:
            return
        self._looked_at = stamp
        point = self.present.point()
        try:
            self.newest = self._ahead.forecast(state, [Span(self._horizon, point)], self._horizon, self._scaled(state))
        except _UNSOLVED as error:  # the estimate goes on without it
            self._node.warn_once("look ahead", f"the look ahead could not be computed: {error}")
            return
        message = LimitPrediction(
            horizon=self._horizon, ambient=float(to_celsius(state.ambient)), rms_current=math.sqrt(point.mean_square_current),
            mean_absolute_speed=point.speed, duty_known=self.present.known, limits=[_row(limit) for limit in self.newest.limits],
        )
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp, 1_000_000_000)
        self._publisher.publish(message)

    def _scaled(self, state: FusionState) -> ScaledDuty | None:
        return self.present.scaled(np.ascontiguousarray(state.dynamic[: len(NODES)]))

    def answer(self, request: PredictLimits.Request, response: PredictLimits.Response) -> PredictLimits.Response:
        """The service `predict_limits`."""
        state = self._state()
        try:
            if state is None:
                raise DutyError("there is no estimate yet")
            horizon = request.horizon or self._horizon
            if not 1.0 <= horizon <= LONGEST_HORIZON:
                raise DutyError(f"horizon: value is {horizon:g} s, allowed are 1 to {LONGEST_HORIZON:g} s")
            schedule, scaled, said = self._asked(request, state, horizon)
            forecast = self._ahead.forecast(state, schedule, horizon, scaled)
        except DutyError as error:
            response.success, response.message = False, str(error)
            return response
        except _UNSOLVED as error:  # the node goes on without it
            response.success, response.message = False, f"the look ahead could not be computed: {error}"
            return response
        point = schedule[0].point
        response.success, response.message = True, said
        response.rms_current, response.mean_absolute_speed = math.sqrt(point.mean_square_current), float(point.speed)
        response.limits = [_row(limit) for limit in forecast.limits]
        response.time = forecast.time.tolist()
        response.locations = [*NODES, HOT_SPOT]
        response.temperature = to_celsius(forecast.temperature).ravel().tolist()
        response.standard_deviation = forecast.standard_deviation.ravel().tolist()
        return response

    def _asked(self, request: PredictLimits.Request, state: FusionState, horizon: float) -> tuple[list[Span], ScaledDuty | None, str]:
        point = self.present.point()
        if request.duty == PredictLimits.Request.REST:
            return [Span(horizon, OperatingPoint.rest(point.position))], None, "rest"
        if request.duty == PredictLimits.Request.GIVEN and request.duty_file:
            return self._given(parse_duty(request.duty_file, "duty_file"), state, horizon)
        if request.duty > PredictLimits.Request.REST:
            raise DutyError(f"duty: value is {request.duty}, allowed are 0 (present), 1 (given) and 2 (rest)")
        if not self.present.known:
            raise DutyError("no telemetry told the present duty yet; ask for rest, or give a duty_file")
        scaled, said = self._scaled(state), "the duty of the last minutes"
        if request.duty == PredictLimits.Request.GIVEN:
            point, said = self._changed(request, point, scaled)
        return [Span(horizon, point)], scaled, said

    def _changed(self, request: PredictLimits.Request, point: OperatingPoint, scaled: ScaledDuty | None) -> tuple[OperatingPoint, str]:
        """The present duty at another speed, at another current, or both."""
        speed, current, most = request.mean_absolute_speed, request.rms_current, self._rig["motor.current_limit"]
        if not 0.0 <= current <= most:
            raise DutyError(f"rms_current: value is {current:g} A, allowed are 0 to {most:g} A")
        if not math.isfinite(speed) or speed < 0.0:
            raise DutyError(f"mean_absolute_speed: value is {speed:g} rad/s, it must not be below 0")
        if speed > 0.0:
            if scaled is None:
                raise DutyError("mean_absolute_speed: the unit has stood still, there is no duty to scale")
            highest = scaled.at(scaled.largest).speed
            if speed > highest:
                raise DutyError(f"mean_absolute_speed: value is {speed:g} rad/s, the duty can be scaled to {highest:.3g} rad/s at most")
            point = scaled.at(speed / point.speed)
        if current > 0.0:
            point = point.with_current(current)
        return point, "the duty of the last minutes, scaled"

    def _given(self, duty: Duty, state: FusionState, horizon: float) -> tuple[list[Span], ScaledDuty | None, str]:
        """A duty file from now on, its losses worked out anew at the temperatures that it leads to; rest after its end."""
        check_for_rig(duty, self._rig)
        temperature, schedule, cycle = state.dynamic[: len(NODES)].copy(), [], 0.0
        end = horizon
        for share in _REVISIONS:
            point, cycle = duty_point(self._rig, duty, temperature, state.ambient)
            end = horizon if duty.repeat == 0 else min(horizon, duty.repeat * cycle)
            schedule.append(Span(share * end, point))
            temperature = self._ahead.mean_temperatures(state, schedule, step_times(share * end))[-1]
        scaled = scaled_duty(self._rig, duty, lambda changed: duty_point(self._rig, changed, temperature, state.ambient)[0])
        if end < horizon:
            schedule.append(Span(horizon, OperatingPoint.rest(duty.start_position)))
            scaled = None
        repeated = "for ever" if duty.repeat == 0 else f"{duty.repeat} times"
        return schedule, scaled, f"the given duty, a cycle of {cycle:.1f} s {repeated}; ambient as it is now"

    def judge(self, report: Report) -> str:
        """The limits for `/diagnostics`: a warning before a limit, an error beyond it, with what would keep it."""
        if self.newest is None:
            return "no estimate yet"
        report.add("warned within", self._warn_within, "s")
        report.add("horizon", self._horizon, "s")
        for row in self.newest.limits:
            celsius, limit = float(to_celsius(row.temperature)), float(to_celsius(row.limit))
            report.add(f"{row.location} now", celsius, "degC")
            report.add(f"{row.location} limit", limit, "degC")
            report.add(f"{row.location} standard deviation", row.standard_deviation, "K")
            report.add(f"{row.location} time to limit", row.time, "s")
            report.add(f"{row.location} time to limit, 16 % sooner", row.time_16, "s")
            report.add(f"{row.location} probability within horizon", row.probability, "1")
            report.add(f"{row.location} allowed current", row.allowed_current, "A")
            report.add(f"{row.location} allowed mean speed", row.allowed_speed, "rad/s")
            keeps = _keeps(row)
            if row.time <= 0.0:
                report.error(f"{row.location} is at {celsius:.1f} degC, limit {limit:g} degC; {keeps}")
            elif min(row.time, row.time_16) <= self._warn_within:
                report.warn(f"{row.location} reaches {limit:g} degC in {_minutes(row.time)}, with 16 % probability in "
                            f"{_minutes(row.time_16)}; {keeps}")
        return "the present duty keeps all limits" if self.present.known else "no telemetry of a duty, rest is looked at"


def _keeps(row: LimitForecast) -> str:
    if row.allowed_current <= 0.0:
        return "no current keeps it"
    said = f"at most {row.allowed_current:.1f} A rms"
    return f"{said} or a mean speed of {row.allowed_speed:.1f} rad/s keep it" if math.isfinite(row.allowed_speed) else f"{said} keep it"


def _minutes(seconds: float) -> str:
    if math.isinf(seconds):
        return "more than the horizon"
    return f"{seconds:.0f} s" if seconds < 120.0 else f"{seconds / 60.0:.0f} min"


def _row(row: LimitForecast) -> TemperatureLimit:
    return TemperatureLimit(
        location=row.location, limit=float(to_celsius(row.limit)), temperature=float(to_celsius(row.temperature)),
        standard_deviation=row.standard_deviation, temperature_at_horizon=float(to_celsius(row.at_horizon)),
        time_to_limit=row.time, time_to_limit_16=row.time_16, time_to_limit_84=row.time_84, probability=row.probability,
        allowed_current=float(row.allowed_current), allowed_speed=float(row.allowed_speed), reached_at_rest=row.reached_at_rest,
    )
