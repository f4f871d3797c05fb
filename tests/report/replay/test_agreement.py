"""Numbers of a comparison against differences known beforehand."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.report.replay.agreement import compare
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC
from ddh_twin_py.twin.hydraulic_model import UNSEEN


def test_known_differences(result):
    agreement = compare(result)
    signals = {s.name: s for s in agreement.signals}
    assert set(signals) >= {"speed", "torque", "pressure_rod_side", "rod_position"} and "speed_command" not in signals
    assert all(s.free_in_noise == pytest.approx(0.5) for s in signals.values())
    assert signals["speed"].rms_soft is None and signals["rod_velocity"].rms_soft is None
    assert signals["torque"].soft_in_noise == pytest.approx(0.25)
    oil = next(t for t in agreement.temperatures if t.sensor == "tank_oil")
    assert (oil.rms_predicted, oil.rms_fused) == (pytest.approx(0.05), pytest.approx(0.02))
    assert oil.predicted == pytest.approx(oil.measured + 0.05)
    assert (oil.samples, oil.refused) == (40, 1)
    assert oil.innovation_in_std == pytest.approx(1.0)
    assert next(x for x in agreement.losses if x.component == "pump 1").soft == 100.0


def test_the_verdict_names_what_is_furthest_off(result):
    agreement = compare(result)
    assert agreement.level == "fair"
    assert "all 8 signals and 1 of 2 temperatures" in agreement.verdict
    assert "motor winding temperature, RMS 0.30 K or 3.0 times noise" in agreement.verdict
    assert agreement.verdict.count(".") >= 1 and "\n" not in agreement.verdict


@pytest.mark.parametrize(("times", "said"), [(1.63, "1.63"), (1.603, "1.603"), (1.66, "1.7"), (3.0, "3.0")])
def test_what_is_beyond_the_limit_is_seen_to_be(result, times, said):
    winding = result.sensors["motor_winding"]
    off = replace(winding, predicted=winding.measured + times * winding.noise)
    verdict = compare(replace(result, sensors={**result.sensors, "motor_winding": off})).verdict
    assert "1 of 2 temperatures" in verdict and f"or {said} times noise" in verdict


def test_all_within_noise_names_no_culprit(result):
    calm = {n: replace(c, predicted=c.measured + 0.1) for n, c in result.sensors.items()}
    agreement = compare(replace(result, sensors=calm))
    assert agreement.level == "good" and "furthest" not in agreement.verdict
    assert "all 2 temperatures" in agreement.verdict


def test_an_estimate_far_from_its_own_sensor_is_said(result):
    lost = {n: replace(c, fused=c.measured - 7.0) for n, c in result.sensors.items()}
    agreement = compare(replace(result, sensors=lost))
    assert agreement.level == "poor"
    assert "fused temperature of tank oil lies 7.00 K RMS from the sensor" in agreement.verdict


def test_the_start_is_left_out_of_the_rms_of_fused_temperatures(result):
    """At the beginning and where the clock jumped back; the figure with it is kept beside."""
    oil = result.sensors["tank_oil"]
    fused = oil.fused.copy()
    fused[:10] += 6.0
    at_start = compare(replace(result, sensors={"tank_oil": replace(oil, fused=fused)})).temperatures[0]
    assert at_start.rms_fused == pytest.approx(0.02) and at_start.rms_fused_whole > 2.0
    back = replace(oil, time=np.concatenate([oil.time[:25], oil.time[:15]]), fused=oil.fused.copy())
    back.fused[25:] += 6.0
    jumped = compare(replace(result, sensors={"tank_oil": back})).temperatures[0]
    assert jumped.rms_fused == pytest.approx(0.02) and jumped.rms_fused_whole > 2.0
    short = replace(oil, **{name: getattr(oil, name)[:10] for name in ("time", "measured", "predicted", "fused", "fused_std")})
    alone = compare(replace(result, sensors={"tank_oil": short})).temperatures[0]
    assert alone.rms_fused == alone.rms_fused_whole == pytest.approx(0.02)


def test_a_held_value_is_no_measurement(result):
    result.measured["hydraulic_age"][200:] = 0.7
    result.free["pressure_rod_side"][200:] += 1e7
    pressure = next(s for s in compare(result).signals if s.name == "pressure_rod_side")
    seen = result.time >= result.time[0] + UNSEEN
    assert pressure.samples == int(seen[:200].sum()) and pressure.free_in_noise == pytest.approx(0.5)
    speed = next(s for s in compare(result).signals if s.name == "speed")
    assert speed.samples == int(seen.sum())


def test_without_pressures_and_temperatures(result):
    for name in ("pressure_piston_side", "pressure_rod_side", "rod_position", "rod_velocity"):
        result.measured[name] = np.nan
    agreement = compare(replace(result, sensors={}, innovations=[]))
    assert {s.name for s in agreement.signals} == {"speed", "torque", "current", "voltage", "electrical_power"}
    assert "no temperature sensor" in agreement.verdict


def test_left_out_sensors(result):
    oil = result.sensors["tank_oil"]
    left_out = {"tank_oil": replace(oil, fused=oil.measured + 0.4, used=False)}
    oil, winding = compare(result, left_out).temperatures
    assert oil.rms_left_out == pytest.approx(0.4) and oil.std_left_out == pytest.approx(0.2)
    assert winding.rms_left_out is None


def test_numbers_that_are_not_finite_are_said_and_never_praised(result):
    result.free["pressure_rod_side"][100:] = np.nan
    agreement = compare(result)
    assert agreement.not_finite == {"pressure rod side": pytest.approx(0.75)}
    assert agreement.level == "poor"
    assert agreement.verdict == (
        "The twin gave no finite numbers for pressure rod side in 75 % of the comparisons: nothing can be said about "
        "agreement; look at the rig file and at the findings."
    )
    assert agreement.as_json()["not_finite"] == {"pressure rod side": pytest.approx(0.75)}


def test_a_twin_that_gave_nothing_at_all(result):
    for name in result.free.dtype.names:
        result.free[name] = np.nan
    nothing = {n: replace(c, predicted=c.measured * np.nan, fused=c.measured * np.inf) for n, c in result.sensors.items()}
    lost = replace(result, sensors=nothing, fused=result.fused * np.nan, fused_std=result.fused_std * np.nan)
    agreement = compare(lost)
    assert agreement.level == "poor"
    assert agreement.verdict.startswith("The twin gave no finite numbers for speed, torque, current, voltage and ")
    assert "agrees" not in agreement.verdict and "stay within" not in agreement.verdict
    assert "fused tank oil temperature" in agreement.not_finite


def test_a_fused_temperature_alone_that_is_not_finite(result):
    odd = dict(result.sensors)
    odd["tank_oil"] = replace(odd["tank_oil"], fused=odd["tank_oil"].fused * np.nan)
    verdict = compare(replace(result, sensors=odd)).verdict
    assert verdict.startswith("The twin gave no finite numbers for fused tank oil temperature: nothing")


def test_a_few_intervals_without_output_are_no_lost_twin(result):
    result.free["speed"][:20] = np.nan
    assert compare(result).not_finite == {}


def test_the_free_run_is_held_against_samples_where_they_lie(result):
    """Samples at the ends of the intervals of a ramp, some of which got lost: neither is a difference."""
    n, time = result.time.size, result.time
    ramp = 100.0 * time
    free, measured = result.free.copy(), result.measured.copy()
    free["speed"], measured["speed"] = ramp - 100.0 * 0.025, ramp
    lost = np.arange(n) % 10 == 3
    measured["speed"][lost] -= 5.0  # what was read before is held
    at = {DRIVE_TOPIC: np.where(lost, np.nan, time)}
    speed = next(s for s in compare(replace(result, free=free, measured=measured, sampled_at=at)).signals if s.name == "speed")
    assert speed.rms_free < 0.02 * speed.noise + 1e-9 and speed.samples == int((~lost & (time >= time[0] + UNSEEN)).sum())
    unaware = next(s for s in compare(replace(result, free=free, measured=measured)).signals if s.name == "speed")
    assert unaware.rms_free > 2.0


def test_the_soft_sensor_is_compared_over_the_span_of_its_row(result):
    soft = result.soft.copy()
    soft["voltage"][result.time < result.time[0] + UNSEEN] += 100.0
    voltage = next(s for s in compare(replace(result, soft=soft)).signals if s.name == "voltage")
    assert voltage.soft_in_noise == pytest.approx(0.25)
    begun = result.time < result.time[0] + 0.5 * UNSEEN  # all that there is
    short = replace(result, time=result.time[begun], measured=result.measured[begun], soft=soft[begun], free=result.free[begun])
    voltage = next(s for s in compare(short).signals if s.name == "voltage")
    assert voltage.soft_in_noise == pytest.approx(0.25 + 100.0 / voltage.noise)


def test_what_moved_before_a_run_began_is_no_difference(result):
    free = result.free.copy()
    early = result.time < result.time[0] + UNSEEN
    free["pressure_piston_side"][early] += 1e6
    pressure = next(s for s in compare(replace(result, free=free)).signals if s.name == "pressure_piston_side")
    assert pressure.free_in_noise == pytest.approx(0.5)
