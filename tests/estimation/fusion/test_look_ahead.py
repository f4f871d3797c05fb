"""Looking ahead: the same network as the filter, times that are true in simulation, duties that keep the limit."""

import dataclasses

import numpy as np
import pytest
from ddh_twin_py.estimation.fusion.duty_ahead import settled_speeds, warmed
from ddh_twin_py.estimation.fusion.inputs import FusionInputs, Reading
from ddh_twin_py.estimation.fusion.look_ahead import (
    HOT_SPOT,
    LookAhead,
    Span,
    crossing,
    default_limits,
    hot_spot,
    largest,
    step_times,
)
from ddh_twin_py.estimation.fusion.temperature_fusion import TemperatureFusion
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import N, N_FLOWS, NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.cycle import PERIOD, DutyRun
from ddh_twin_py.twin.duty import DutyError, load_duty
from ddh_twin_py.twin.operating_point import (
    LEAST_SEEN,
    OLDEST,
    TELLS_AHEAD,
    OperatingPoint,
    PresentDuty,
    ScaledDuty,
    duty_point,
    duty_scales,
    measured_rows,
    scaled_in_speed,
)
from support.simulated import DUTY

AIR = 296.15


@pytest.fixture(scope="module")
def rig():
    return load_rig()


@pytest.fixture(scope="module")
def state(rig):
    fusion = TemperatureFusion(rig, ambient=AIR)
    for _ in range(20):
        fusion.advance(FusionInputs.unknown(20), [Reading(1, sensor, 300.0) for sensor in SENSORS])
    return fusion.state


@pytest.fixture(scope="module")
def duty():
    return load_duty(DUTY / "paper_cycle.yaml")


@pytest.fixture(scope="module")
def point(rig, duty):
    return duty_point(rig, duty, np.full(N, 300.0), AIR)[0]


@pytest.fixture(scope="module")
def ahead(rig):
    return LookAhead(rig, default_limits(rig))


def row(forecast, location=HOT_SPOT):
    return next(limit for limit in forecast.limits if limit.location == location)


def test_a_duty_costs_what_the_free_run_says(point):
    assert 4.0 < np.sqrt(point.mean_square_current) < 7.0 and 30.0 < point.speed < 52.4
    assert point.heat[NODES.index("pump_1_oil")] > 50.0 and np.all(point.flow >= 0.0)


def test_long_steps_agree_with_the_filters_own_intervals(ahead, state, point, rig):
    """Growing steps up to minutes against the filter's mean at 1 s intervals."""
    fusion = TemperatureFusion(rig, interval=1.0, ambient=AIR)
    fusion.state = dataclasses.replace(state, **{name: getattr(state, name).copy() for name in ("dynamic", "deviation", "offset")},
                                       covariance=state.covariance.copy(), usual_heat=state.usual_heat.copy())
    n = 1800
    inputs = FusionInputs(np.tile(point.heat, (n, 1)), np.full(n, point.mean_square_current), np.tile(point.flow, (n, 1)),
                          np.full(n, point.position), np.ones(n, bool), np.ones(n, bool), np.full(n, AIR))
    fine = fusion.advance(inputs).temperature[-1]
    coarse = ahead.mean_temperatures(state, [Span(n, point)], step_times(n))[-1]
    np.testing.assert_allclose(coarse, fine, atol=0.1)


def test_looking_does_not_change_the_state(ahead, state, point):
    before = [np.copy(a) for a in (state.dynamic, state.deviation, state.covariance)]
    first = ahead.forecast(state, [Span(600.0, point)], 600.0)
    second = ahead.forecast(state, [Span(600.0, point)], 600.0)
    for a, b in zip(before, (state.dynamic, state.deviation, state.covariance), strict=True):
        np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(first.temperature, second.temperature)


def test_more_current_is_sooner_and_rest_never(ahead, state, point):
    times = [row(ahead.forecast(state, [Span(7200.0, point.with_current(rms))], 7200.0)).time for rms in (8.0, 10.0, 14.0)]
    assert np.isfinite(times[0]) and times[0] > times[1] > times[2] > 10.0
    rest = row(ahead.forecast(state, [Span(3600.0, OperatingPoint.rest())], 3600.0))
    assert np.isinf(rest.time) and not rest.reached_at_rest and np.isnan(rest.allowed_speed)


def test_bounds_lie_around_the_time_and_probability_follows(ahead, state, point):
    limit = row(ahead.forecast(state, [Span(7200.0, point.with_current(9.0))], 7200.0))
    assert limit.time_16 < limit.time < limit.time_84 and limit.probability > 0.9
    far = row(ahead.forecast(state, [Span(7200.0, point.with_current(3.0))], 7200.0))
    assert np.isinf(far.time) and far.probability == 0.0


def test_the_time_is_true_of_drawn_units(ahead, state, point, rig):
    """Units drawn from the covariance by other means than the forecast's own: 68 % of their times within the bounds."""
    limit = row(ahead.forecast(state, [Span(7200.0, point.with_current(9.0))], 7200.0))
    other = LookAhead(rig, default_limits(rig))
    rng = np.random.default_rng(7)
    other._normal, other._wander = rng.standard_normal((200, other._normal.shape[1])), rng.standard_normal((200, *other._wander.shape[1:]))
    times = step_times(7200.0)
    paths = other._drawn(state, [Span(7200.0, point.with_current(9.0))], times)
    windings = paths[:, :, [i for i, n in enumerate(NODES) if "winding" in n]].max(axis=2)
    hot = windings + 0.095 * (windings - AIR)
    reached = np.array([crossing(times, path, limit.limit) for path in hot])
    assert 0.5 < np.mean((reached > limit.time_16) & (reached < limit.time_84)) < 0.9


def test_the_allowed_current_keeps_the_limit_and_a_little_more_does_not(ahead, state, point):
    limit = row(ahead.forecast(state, [Span(3600.0, point)], 3600.0))
    long = 5 * 86400.0
    kept, broken = (
        row(ahead.forecast(state, [Span(long, point.with_current(f * limit.allowed_current))], long)) for f in (0.99, 1.02)
    )
    assert np.isinf(kept.time) and np.isfinite(broken.time)


def test_the_allowed_speed_keeps_the_oil(rig, state, duty):
    limits = default_limits(rig) | {"oil": ZERO_CELSIUS + 35.0}
    ahead = LookAhead(rig, limits)

    def cost(changed):
        return duty_point(rig, changed, np.full(N, 300.0), AIR)[0]

    scales = duty_scales(rig, duty)
    at_rest = OperatingPoint.rest(duty.start_position)
    scaled = ScaledDuty(scales, [at_rest, *(cost(scaled_in_speed(duty, scale)) for scale in scales[1:])])
    limit = row(ahead.forecast(state, [Span(3600.0, cost(duty))], 3600.0, scaled), "oil")
    assert 0.0 < limit.allowed_speed < cost(duty).speed
    scale = largest(lambda s: scaled.at(s).speed - limit.allowed_speed, scaled.largest)
    long = 5 * 86400.0
    settled = ahead.forecast(state, [Span(long, scaled.at(0.98 * scale))], long)
    assert row(settled, "oil").at_horizon < limits["oil"]


def test_the_present_duty_is_the_mean_of_the_window(rig):
    present = PresentDuty(rig, 0.05)
    assert not present.known and present.point().speed == 0.0 and present.changed(np.full(N, 300.0)) is None
    n = 4000  # longer than the window; the first part must be forgotten
    speed = np.where(np.arange(n) < 1600, 200.0, 50.0)
    values = {"speed": speed, "pressure_piston_side": np.full(n, 2e6), "rod_velocity": np.full(n, 0.05), "rod_position": np.full(n, 0.2),
              "current": np.full(n, 5.0), "current_square": np.full(n, 25.0)}
    measured = measured_rows(values, n)
    for k in range(0, n, 100):
        rows = slice(k, k + 100)
        present.add(np.full((100, N), 3.0), np.zeros((100, N_FLOWS)), np.full(100, 25.0), measured[rows])
    point = present.point()
    assert point.speed == 50.0 and point.mean_square_current == 25.0 and point.heat[0] == 3.0
    warm = np.full(N, 300.0)
    changed = present.changed(warm)
    scaled = ScaledDuty(changed.scales, [changed(scale, warm) for scale in changed.scales])
    assert scaled.at(1.0).heat == pytest.approx(point.heat) and scaled.at(2.0).speed == pytest.approx(100.0)
    pump = NODES.index("pump_1_oil")
    assert scaled.at(0.5).heat[pump] < point.heat[pump] < scaled.at(2.0).heat[pump]


@pytest.fixture(scope="module")
def measured_cold(rig, duty):
    """Three cycles of the paper's duty with the unit held at 23 degC, as a present duty."""
    run, present = DutyRun(rig, duty, AIR, AIR), PresentDuty(rig, PERIOD)
    for _ in range(3):
        run.temperature[:] = AIR
        points = run.cycle(keep=True).points
        names = ("speed", "pressure_piston_side", "pressure_rod_side", "rod_velocity", "rod_position", "current")
        rows = measured_rows({name: points[name] for name in names}, points.size)
        present.add(points["heat"], points["flow"], points["mean_square_current"], rows)
    return present


def test_a_cold_duty_is_foreseen_as_the_free_run_does_it(rig, duty, measured_cold):
    fusion = TemperatureFusion(rig, ambient=AIR)
    for _ in range(20):
        fusion.advance(FusionInputs.unknown(20), [Reading(1, sensor, AIR) for sensor in SENSORS])
    cold, hour = fusion.state, 3600.0
    ahead = LookAhead(rig, default_limits(rig))
    changed = measured_cold.changed(np.ascontiguousarray(cold.dynamic[:N]))
    schedule = warmed(ahead, cold, changed, hour)
    run = DutyRun(rig, duty, AIR, AIR)
    while run.time < hour:
        run.cycle()
    windings = [NODES.index("slot_winding"), NODES.index("end_winding")]
    true, times = run.temperature[windings], np.linspace(0.0, hour, 61)
    told, held = (ahead.mean_temperatures(cold, spans, times)[-1, windings] for spans in (schedule, [Span(hour, measured_cold.point())]))
    assert np.all(np.abs(told - true) < 0.08 * (true - AIR))
    assert np.all(held - true > 40.0)  # what the current of the cold oil would do
    assert np.isinf(row(ahead.forecast(cold, schedule, hour)).time)


def test_rest_and_the_duty_itself_are_where_a_changed_duty_begins(measured_cold):
    cold = np.full(N, AIR)
    changed = measured_cold.changed(cold)
    same, point = changed(1.0, cold), measured_cold.point()
    assert same.heat == pytest.approx(point.heat) and same.mean_square_current == pytest.approx(point.mean_square_current)
    assert changed(0.0, cold).mean_square_current == 0.0 and not changed(0.0, cold).heat.any()
    currents = [changed(1.0, np.full(N, AIR + warm)).mean_square_current for warm in (0.0, 10.0, 20.0, 30.0)]
    assert currents == sorted(currents, reverse=True) and currents[1] < 0.6 * currents[0]


def test_the_allowed_speed_counts_the_oil_that_it_cools_to(rig, state, measured_cold):
    limits = default_limits(rig) | {HOT_SPOT: AIR + 25.0}
    ahead = LookAhead(rig, limits)
    changed = measured_cold.changed(np.full(N, AIR))
    speeds = settled_speeds(ahead, state, changed, changed.scales)
    allowed = row(ahead.forecast(state, warmed(ahead, state, changed, 3600.0), 3600.0, speeds)).allowed_speed
    speed = measured_cold.point().speed
    assert 0.0 < allowed < speed
    days = 5 * 86400.0
    for factor, kept in ((0.9, True), (1.3, False)):
        scale = factor * allowed / speed
        schedule = warmed(ahead, state, lambda f, t, scale=scale: changed(f * scale, t), days)
        assert np.isinf(row(ahead.forecast(state, schedule, days)).time) == kept


def test_seconds_of_a_duty_tell_minutes_and_a_window_tells_all(rig):
    present = PresentDuty(rig, 0.05)
    assert present.tells_ahead == np.inf  # rest is looked at
    rows = measured_rows({"speed": np.full(100, 50.0)}, 100)
    for k in range(24):
        present.add(np.zeros((100, N)), np.zeros((100, N_FLOWS)), np.ones(100), rows)
        assert present.seen == pytest.approx(5.0 * (k + 1))
        told = 0.0 if present.seen < LEAST_SEEN else TELLS_AHEAD * present.seen  # a single stroke is no duty
        assert present.tells_ahead == (np.inf if k == 23 else pytest.approx(told))


def test_a_duty_that_is_long_past_is_not_the_present_one(rig):
    present = PresentDuty(rig, 0.05)
    rows = measured_rows({"speed": np.full(100, 50.0)}, 100)
    for _ in range(30):
        present.passes(100)
        present.add(np.zeros((100, N)), np.zeros((100, N_FLOWS)), np.ones(100), rows)
    assert present.seen == pytest.approx(120.0)
    present.passes(round(0.9 * OLDEST / 0.05))
    assert present.known and present.seen < 60.0, "what is left is the newest of it"
    present.passes(round(0.2 * OLDEST / 0.05))
    assert not present.known and present.point().mean_square_current == 0.0


def test_the_hot_spot_lies_above_the_winding_and_widens_with_the_rise():
    temperature = np.full((2, N), AIR)
    temperature[1, NODES.index("end_winding")] += 105.0
    told, spread = hot_spot(temperature, np.full((2, N), 1.0), AIR)
    assert told[0] == AIR and told[1] == pytest.approx(AIR + 105.0 + 9.975)
    assert spread[0] == pytest.approx(1.095) and spread[1] > 5.0


def test_a_cycle_without_end_is_refused(rig, duty):
    endless = dataclasses.replace(duty, cycle=tuple(dataclasses.replace(s, kind="dwell", duration=1e4) for s in duty.cycle[:1]))
    with pytest.raises(DutyError, match="one cycle takes more than"):
        duty_point(rig, endless, np.full(N, 300.0), AIR)


def test_a_late_reading_is_used_at_its_time(rig):
    """Readings 5 s late lead to the estimate that they lead to in time, less surely never more."""
    in_time, late = TemperatureFusion(rig, ambient=AIR), TemperatureFusion(rig, ambient=AIR)
    for k in range(60):
        rising = AIR + 0.05 * k
        in_time.advance(FusionInputs.unknown(20), [Reading(10, "tank_oil", rising)])
        late.advance(FusionInputs.unknown(20), [Reading(10 - 100, "tank_oil", rising - 0.25)] if k >= 6 else [])
    tank = NODES.index("tank_oil")
    first, second = (np.sqrt(f.state.covariance[tank, tank]) for f in (in_time, late))
    assert 0.95 * first < second < 1.5 and late.state.refused[SENSORS.index("tank_oil")] == 0
    assert abs(late.state.dynamic[tank] - in_time.state.dynamic[tank]) < 0.5


def test_a_reading_older_than_what_is_remembered_is_left_out(rig):
    fusion = TemperatureFusion(rig, ambient=AIR)
    fusion.advance(FusionInputs.unknown(40))
    before = fusion.state.covariance.copy()
    told = fusion.advance(FusionInputs.unknown(20), [Reading(-5000, "tank_oil", 330.0)])
    assert told.innovations == [] and before.shape == fusion.state.covariance.shape


@pytest.mark.parametrize("rms", [9.0, 12.0, 20.0, 23.5, 60.0])
def test_currents_that_trip_the_drive_stay_finite_and_never_cool(ahead, state, point, rms):
    """Copper loss grows with its own heat: whatever the steps, hotter with more current, up to the drive's cut-back."""
    forecast = ahead.forecast(state, [Span(3600.0, point.with_current(rms))], 3600.0)
    winding = forecast.temperature[:, NODES.index("end_winding")]
    assert np.isfinite(forecast.temperature).all() and np.isfinite(forecast.standard_deviation).all()
    assert np.all(np.diff(winding) > -0.5) and winding.max() < ZERO_CELSIUS + 262.0
    milder = ahead.forecast(state, [Span(3600.0, point.with_current(0.9 * rms))], 3600.0)
    assert row(milder).time >= row(forecast).time
    assert np.isfinite(row(forecast).allowed_current)


def test_what_cannot_be_computed_allows_nothing():
    assert largest(lambda value: float("nan"), 10.0) == 0.0
    assert largest(lambda value: value - 4.0 if value < 6.0 else float("nan"), 10.0) == pytest.approx(4.0, abs=0.05)
