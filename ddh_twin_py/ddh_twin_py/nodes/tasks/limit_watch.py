"""How far the limits are: topic `temperature/limits`, service `predict_limits`, warnings in `/diagnostics`."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ddh_msgs.msg import LimitPrediction, TemperatureLimit
from ddh_msgs.srv import PredictLimits
from ddh_twin_py.estimation.fusion.duty_ahead import ROUNDS, settled_speeds, warmed
from ddh_twin_py.estimation.fusion.look_ahead import HOT_SPOT, Forecast, LimitForecast, LookAhead, Span, default_limits
from ddh_twin_py.estimation.fusion.state import FusionState
from ddh_twin_py.names import short
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.nodes.base.times import set_time
from ddh_twin_py.nodes.messages.conversion import to_celsius, to_kelvin
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.physics.thermal_network import N, N_FLOWS, NODES
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.duty import Duty, DutyError, check_for_rig, parse_duty
from ddh_twin_py.twin.operating_point import (
    LONGEST_CYCLE,
    ChangedDuty,
    OperatingPoint,
    PresentDuty,
    ScaledDuty,
    duty_point,
    duty_scales,
    measured_rows,
    scaled_in_speed,
)

PERIOD = 1.0  # s of wall time
LONGEST_HORIZON = 604800.0  # s
_UNSOLVED = (ValueError, ArithmeticError, np.linalg.LinAlgError)
_SPEEDS_EVERY = 10  # looks, after which what other speeds settle at is worked out anew
_RUN_AT_MOST = 240.0  # s of cycles of a given duty that a question runs to follow the temperatures
_SHORT_CYCLE = 60.0  # s; a longer one is run once for each speed

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
        self._speeds: ScaledDuty | None = None
        self._looks = 0
        self._publisher = node.create_publisher(LimitPrediction, "temperature/limits", qos.OUTPUT)
        node.create_service(PredictLimits, "predict_limits", self.answer)
        node.every(PERIOD, self.look)

    def warm_up(self, state: FusionState) -> None:
        """Load or compile now what a look needs, so that no estimate waits for it."""
        present = PresentDuty(self._rig, self._node.values["interval"])
        one = np.ones(1)
        rows = measured_rows({"speed": one, "current": one, "pressure_piston_side": 1e6 * one}, 1)
        present.add(np.zeros((1, N)), np.zeros((1, N_FLOWS)), one, rows)
        changed = present.changed(np.ascontiguousarray(state.dynamic[:N]))
        speeds = settled_speeds(self._ahead, state, changed, changed.scales[:2])
        self._ahead.forecast(state, warmed(self._ahead, state, changed, 60.0), 60.0, speeds)

    def look(self) -> None:
        """Publish how the limits stand, where there is a new estimate."""
        state, stamp = self._state(), self._stamp_ns()
        if state is None or stamp == self._looked_at:
            return
        self._looked_at = stamp
        point, changed = self.present.point(), self._changed_duty(state)
        try:
            if changed is None:
                schedule, self._speeds, self._looks = [Span(self._horizon, point)], None, 0
            else:
                schedule = warmed(self._ahead, state, changed, self._horizon)
                if self._looks % _SPEEDS_EVERY == 0:
                    self._speeds = settled_speeds(self._ahead, state, changed, changed.scales)
                self._looks += 1
            self.newest = self._ahead.forecast(state, schedule, self._horizon, self._speeds)
        except _UNSOLVED as error:  # the estimate goes on without it
            self._node.warn_once("look ahead", f"the look ahead could not be computed: {error}")
            return
        message = LimitPrediction(
            horizon=self._horizon, ambient=float(to_celsius(state.ambient)), rms_current=math.sqrt(point.mean_square_current),
            mean_absolute_speed=point.speed, duty_known=self.present.known, limits=[_row(limit) for limit in self.newest.limits],
        )
        set_time(message.header.stamp, stamp)
        self._publisher.publish(message)

    def _changed_duty(self, state: FusionState) -> ChangedDuty | None:
        return self.present.changed(np.ascontiguousarray(state.dynamic[:N]))

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
            response.success, response.message = False, short(str(error))
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
        changed, said = self._changed_duty(state), "the duty of the last minutes"
        speeds = settled_speeds(self._ahead, state, changed, changed.scales)
        scale, current = 1.0, 0.0
        if request.duty == PredictLimits.Request.GIVEN:
            scale, current, said = *self._wanted(request, point, changed), "the duty of the last minutes, scaled"
        schedule = warmed(self._ahead, state, lambda factor, temperature: changed(scale * factor, temperature), horizon)
        if current > 0.0:
            schedule = [Span(span.end, span.point.with_current(current)) for span in schedule]
        return schedule, speeds, said

    def _wanted(self, request: PredictLimits.Request, point: OperatingPoint, changed: ChangedDuty) -> tuple[float, float]:
        """The factor on the speed of the present duty, and its current where that is asked for, else 0."""
        speed, current, most = request.mean_absolute_speed, request.rms_current, self._rig["motor.current_limit"]
        if not 0.0 <= current <= most:
            raise DutyError(f"rms_current: value is {current:g} A, allowed are 0 to {most:g} A")
        if not math.isfinite(speed) or speed < 0.0:
            raise DutyError(f"mean_absolute_speed: value is {speed:g} rad/s, it must be finite and not below 0")
        if speed == 0.0:
            return 1.0, current
        if not changed.scales.size:
            raise DutyError("mean_absolute_speed: the unit has stood still, there is no duty to scale")
        highest = changed.scales[-1] * point.speed
        if speed > highest:
            raise DutyError(f"mean_absolute_speed: value is {speed:g} rad/s, the duty can be scaled to {highest:.3g} rad/s at most")
        return speed / point.speed, current

    def _given(self, duty: Duty, state: FusionState, horizon: float) -> tuple[list[Span], ScaledDuty | None, str]:
        """A duty file from now on, its losses worked out anew at the temperatures that it leads to; rest after its end."""
        check_for_rig(duty, self._rig)
        _, cycle = duty_point(self._rig, duty, state.dynamic[:N], state.ambient)
        end = horizon if duty.repeat == 0 else min(horizon, duty.repeat * cycle)

        def cost(scale: float, temperature: np.ndarray) -> OperatingPoint:
            if scale <= 0.0:
                return OperatingPoint.rest(duty.start_position)
            return duty_point(self._rig, scaled_in_speed(duty, scale), temperature, state.ambient)[0]

        schedule = warmed(self._ahead, state, cost, end, max(3, round(0.5 * _RUN_AT_MOST / cycle)))
        speeds = None
        if end < horizon:
            schedule.append(Span(horizon, OperatingPoint.rest(duty.start_position)))
        else:
            scales = duty_scales(self._rig, duty)
            scales = scales[(scales == 0.0) | (cycle <= scales * LONGEST_CYCLE)]
            rounds = 1 if cycle > _SHORT_CYCLE else ROUNDS
            speeds = settled_speeds(self._ahead, state, cost, scales, rounds) if scales.size > 1 else None
        repeated = "for ever" if duty.repeat == 0 else f"{duty.repeat} times"
        return schedule, speeds, f"the given duty, a cycle of {cycle:.1f} s {repeated}; ambient as it is now"

    def judge(self, report: Report) -> str:
        """The limits for `/diagnostics`: a warning before a limit, an error beyond it, with what would keep it."""
        if self.newest is None:
            return "no estimate yet"
        report.add("warned within", self._warn_within, "s")
        report.add("horizon", self._horizon, "s")
        report.add("duty seen", self.present.seen, "s")
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
            elif min(row.time, row.time_16) <= min(self._warn_within, self.present.tells_ahead):
                report.warn(f"{row.location} reaches {limit:g} degC in {_minutes(row.time)}, with 16 % probability in "
                            f"{_minutes(row.time_16)}; {keeps}")
        if not self.present.known:
            return "no telemetry of a duty, rest is looked at"
        tells = self.present.tells_ahead
        if any(tells < min(row.time, row.time_16) <= self._horizon for row in self.newest.limits):
            return f"the {self.present.seen:.0f} s of duty that were seen are too few to say when a limit is reached"
        return "the present duty keeps all limits"


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
