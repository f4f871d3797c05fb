"""Cold start: the allowed speed, two rates against the full free run, what must be monotonic."""

from concurrent.futures import CancelledError
from dataclasses import replace
from threading import Event

import numpy as np
import pytest
from ddh_twin_py.physics.hydraulics import HYDRAULIC_STATES
from ddh_twin_py.physics.oil import VAPOUR_PRESSURE, ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import END_WINDING, N, NODES, SLOT_WINDING, TANK
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.cold_start import LONGEST_CYCLE, AllowedSpeed, Case, start, sweep
from ddh_twin_py.twin.cycle import DutyRun
from ddh_twin_py.twin.duty import DutyCommand, load_duty
from ddh_twin_py.twin.possible_speed import CURRENT_SHARE, STEADY, SUCTION_MARGIN, highest_speed, steady_operation


@pytest.fixture(scope="module")
def rig():
    return load_rig()


@pytest.fixture(scope="module")
def duties(repo_root):
    folder = repo_root / "ddh_twin_py/config/duty"
    return {name: load_duty(folder / f"{name}.yaml") for name in ("paper_cycle", "paper_cycle_each_minute", "paper_cycle_fast")}


def steady_state(params, temperature, speed):
    """`steady_operation` at mid-stroke, by name."""
    out = np.empty(len(STEADY))
    steady_operation(params, temperature, speed, 0.5 * float(params[0]["cylinder_stroke"]), out)
    return dict(zip(STEADY, out, strict=True))


@pytest.mark.parametrize("speed", [40.0, -40.0])
@pytest.mark.parametrize("celsius", [0.0, 23.0, 50.0])
def test_what_a_speed_settles_to_is_where_the_free_run_goes(rig, celsius, speed):
    from ddh_twin_py.physics.balance import OPERATING_DTYPE
    from ddh_twin_py.physics.free_run import free_run, settle
    from ddh_twin_py.twin.intervals import command_size

    temperature = np.full(N, celsius + ZERO_CELSIUS)
    stays = rig.with_values({path: 50.0 * rig[path] for path in rig.quantities if path.startswith("pump_") and path.endswith(
        ("oil_volume",))})  # oil that hardly warms, so that its viscosity stays
    steady = steady_state(stays.parameters, temperature, speed)
    state = np.zeros(len(HYDRAULIC_STATES))
    pressures = [max(steady[f"pressure_{side}_side"], 0.0) for side in ("piston", "rod")]
    settle(stays.parameters, state, 0.1 if speed > 0.0 else 0.3, *pressures)
    n = 60
    command = np.minimum(np.arange(command_size(n)) * 2.0, abs(speed)) * np.sign(speed)
    points, temperatures = np.zeros(n, OPERATING_DTYPE), np.empty((n, N))
    free_run(stays.parameters, state, temperature.copy(), command, np.full(n, temperature[0]), 0.05, 1e-3, np.full(n, np.nan), points,
             temperatures)
    last = points[-1]
    assert last["rod_velocity"] == pytest.approx(steady["rod_velocity"], rel=5e-3)
    assert last["torque"] == pytest.approx(steady["torque"], rel=1e-2, abs=0.02)
    assert last["pressure_piston_side"] == pytest.approx(steady["pressure_piston_side"], rel=1e-2)
    assert last["pressure_rod_side"] == pytest.approx(steady["pressure_rod_side"], rel=1e-2)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_allowed_speed_is_on_its_limit_and_rises_with_temperature(rig, sign):
    oil = rig.with_oil("ISO VG 46").parameters
    out, before = np.empty(len(STEADY)), 0.0
    seen = set()
    for celsius in (-30.0, -25.0, -20.0, -15.0, -10.0, -5.0):
        temperature = np.full(N, celsius + ZERO_CELSIUS)
        speed, reason = highest_speed(oil, temperature, sign, 200.0, 100.0, out)
        assert speed > before
        before = speed
        seen.add(reason)
        a_little_more = steady_state(oil, temperature, sign * (1.01 * speed + 0.2))
        current = (abs(a_little_more["torque"]) + 100.0 * rig["motor.inertia"]) / rig["motor.torque_constant"]
        least = min(a_little_more[name] for name in STEADY if name.endswith("pressure") or name.startswith("pressure"))
        if reason == 1:
            assert current > CURRENT_SHARE * rig["motor.current_limit"]
        else:
            assert reason == 2 and least < VAPOUR_PRESSURE + SUCTION_MARGIN
    assert seen


def test_a_longer_line_makes_suction_the_limit_of_lowering(rig):
    narrow = rig.with_oil("ISO VG 46").with_values({"line_a.pressure_drop_laminar": 20.0 * rig["line_a.pressure_drop_laminar"]})
    temperature, out = np.full(N, 253.15), np.empty(len(STEADY))
    assert highest_speed(narrow.parameters, temperature, -1.0, 200.0, 100.0, out)[1] == 2


def reference(rig, duty, case, hours):
    """Every cycle by the full free run with the same rule: times, temperatures, time of full speed, time over the limit."""
    filled = rig.with_oil(case.grade).with_values({"load.payload_mass": duty.payload})
    run = DutyRun(filled, duty, case.ambient + ZERO_CELSIUS, case.ambient + ZERO_CELSIUS, patient=True)
    rule = AllowedSpeed(filled, duty)
    time, history, full = [0.0], [run.temperature.copy()], np.nan
    while time[-1] < 3600.0 * hours:
        shares, _ = rule.shares(run.temperature)
        if np.isnan(full) and min(shares) >= 1.0:
            full = time[-1]
        time.append(time[-1] + run.cycle(*rule.caps(shares), longest=LONGEST_CYCLE).duration)
        history.append(run.temperature.copy())
    return np.array(time), np.array(history), full


@pytest.mark.parametrize("duty, grade, ambient", [
    ("paper_cycle", "ISO VG 32", 0.0), ("paper_cycle_fast", "ISO VG 32", -10.0), ("paper_cycle_each_minute", "ISO VG 68", -10.0),
])
def test_two_rates_agree_with_the_full_free_run(rig, duties, duty, grade, ambient):
    """Bounds: tank oil 0.5 K, windings 4 K at any time and 1 K after an hour, time of full speed 6 %."""
    case = Case(ambient, grade, duty)
    time, history, full = reference(rig, duties[duty], case, 1.0)
    outcome = start(rig, duties[duty], case, 1.0)
    within = outcome.time <= time[-1]
    exact = np.array([np.interp(outcome.time[within], time, history[:, i]) for i in range(N)]).T
    off = np.abs(outcome.history[within] - exact)
    assert outcome.cycles < 0.5 * time.size
    assert off[:, TANK].max() < 0.5
    assert off[:, [SLOT_WINDING, END_WINDING]].max() < 4.0
    assert off[-1].max() < 1.0, NODES[int(np.argmax(off[-1]))]
    assert outcome.time_to_full == pytest.approx(full, rel=0.06, abs=1.0)


def test_smaller_steps_change_little(rig, duties):
    case = Case(-10.0, "ISO VG 46", "paper_cycle_each_minute")
    coarse = start(rig, duties[case.duty], case, 2.0)
    fine = start(rig, duties[case.duty], case, 2.0, oil_bound=0.3)
    assert fine.cycles > 1.3 * coarse.cycles
    assert coarse.tank_oil == pytest.approx(fine.tank_oil, abs=0.5)
    assert coarse.winding_peak == pytest.approx(fine.winding_peak, abs=4.0)
    assert coarse.time_to_full == pytest.approx(fine.time_to_full, rel=0.06)


def test_the_answer_flips_with_ambient_and_oil(rig, duties):
    ambients, grades = (-30.0, -15.0, 0.0, 20.0), ("ISO VG 15", "ISO VG 32", "ISO VG 68")
    cases = [Case(t, g, "paper_cycle_each_minute") for g in grades for t in ambients]
    seen = []
    outcomes = sweep(rig, duties, cases, 1.0, seen.append, workers=2)
    assert [o.case for o in outcomes] == cases and seen[-1] == 1.0 and sorted(seen) == seen
    at = {(o.case.grade, o.case.ambient): o for o in outcomes}
    for grade in grades:
        assert all(at[grade, a].first_raise <= at[grade, b].first_raise for a, b in zip(ambients, ambients[1:], strict=False))
    for ambient in ambients:
        assert all(at[a, ambient].first_raise >= at[b, ambient].first_raise for a, b in zip(grades, grades[1:], strict=False))
    assert {o.verdict for o in outcomes} >= {"full at once", "reaches full speed", "overheats"}
    for o in outcomes:
        assert o.extrapolated == (o.case.ambient < -20.0)
        assert (o.time_to_full == 0.0) == (min(o.first_raise, o.first_lower) >= 1.0)
        assert (o.verdict == "overheats") == (o.winding_peak > rig["motor.thermal.winding_limit"])
        if o.cycles:
            assert o.tank_oil > o.case.ambient


def test_a_unit_that_cannot_move_stays_cold(rig, duties):
    weak = rig.with_values({"motor.current_limit": 5.0})
    outcome = start(weak, duties["paper_cycle"], Case(-30.0, "ISO VG 68", "paper_cycle"), 1.0)
    assert (outcome.verdict, outcome.cycles, outcome.first_limit) == ("stuck", 0, "current")
    assert outcome.tank_oil == outcome.winding_peak == -30.0


def test_one_control_for_duty_and_cycle(rig, duties):
    """The duty's control step by step in Python and the compiled cycle go the same way."""
    duty = duties["paper_cycle"]
    run = DutyRun(rig, duty, 296.15, 296.15)
    one = run.cycle(longest=60.0, keep=True)
    record = rig.parameters[0]
    per_rad = record["pump_1_displacement"] / (2.0 * np.pi) / (0.25 * np.pi * record["cylinder_bore"] ** 2)
    command, said = DutyCommand(duty), []
    positions = np.concatenate([[duty.start_position], one.points["rod_position"][:-1]])
    for position in positions:
        said.append(command.step(position, per_rad, 0.02))
    assert np.abs(np.array(said) - one.points["speed"]).max() < 6.0  # the shaft's lag of 15 ms at 120 rad/s2, and half a period
    assert one.duration == pytest.approx(15.7, abs=0.6)


def test_what_is_declared_is_lifted_times_the_rigs_ratio(rig, duties):
    """Of a rig that lifts twice what is declared, half as much declared is the same load, inertia and holding pressure."""
    whole = duties["paper_cycle"]
    half = replace(whole, payload=0.5 * whole.payload)
    air = float(whole.ambient[0])
    runs = [DutyRun(of.declaring(duty.payload), duty, air, air).cycle(keep=True).points["pressure_piston_side"][:100]
            for of, duty in ((rig, whole), (rig.with_values({"load.payload_ratio": 2.0}), half), (rig, half))]
    same, as_declared = (np.abs(other - runs[0]).max() for other in runs[1:])
    assert same == 0.0 and as_declared > 1e5  # Pa
    assert rig.declaring(None) is rig.declaring(np.nan) is rig.declaring(np.inf) is rig


def test_a_start_can_be_stopped(rig, duties):
    stop = Event()
    stop.set()
    with pytest.raises(CancelledError):
        start(rig, duties["paper_cycle"], Case(20.0, "ISO VG 32", "paper_cycle"), 1000.0, stop=stop)
