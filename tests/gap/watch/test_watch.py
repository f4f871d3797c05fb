"""The gap watch: which bins count, levels by phase, temperatures against the movement of the same time."""

import numpy as np
import pytest
from ddh_twin_py.gap.watch.watch import HYDRAULIC, TEMPERATURES, GapWatch, Settings
from ddh_twin_py.rig import load_rig

TICK = 50_000_000
NAMES = [name for name, _, _ in HYDRAULIC]
PISTON = NAMES.index("pressure_piston_side")
SETTINGS = Settings(bin_length=2.0, learning=80.0, between_alarms=3.6e6)


@pytest.fixture(scope="module")
def rig():
    return load_rig(None)


class Machine:
    """Lifts and lowers by turns of 0.5 s; residuals at the sheet's noise about levels of each phase."""

    def __init__(self, rig, watch, moves=True):
        self.rng, self.watch, self.at, self.moves = np.random.default_rng(2), watch, 0, moves
        self.noise = np.array([rig.sensors[key].noise for _, key, _ in HYDRAULIC])

    def run(self, seconds, departs=0.0, warmer=0.0):
        n = round(seconds / 0.05)
        stamps = self.at + TICK * np.arange(1, n + 1)
        self.at = int(stamps[-1])
        lifts = (stamps // (10 * TICK)) % 2 == 0
        velocity = np.where(lifts, 0.05, -0.05) if self.moves else np.zeros(n)
        predicted = np.zeros((n, len(NAMES)))
        measured = self.noise * self.rng.standard_normal(predicted.shape)
        measured[:, PISTON] += np.where(lifts, 2e5, -1e5) + departs
        shown, _ = self.watch.take_hydraulics(stamps, measured, predicted, velocity)
        reading = np.where((stamps // TICK) % 20 == 0, 30.0, np.nan)[:, None] + np.zeros(len(TEMPERATURES))
        reading += 0.1 * self.rng.standard_normal(reading.shape)
        reading[:, TEMPERATURES.index("temperature/tank_oil")] += warmer
        self.watch.take_temperatures(stamps, reading, np.full(reading.shape, 29.5))
        return shown


def test_a_pressure_that_departs_opens_its_gap_and_points_to_the_sensor(rig):
    watch = GapWatch(rig, SETTINGS)
    machine = Machine(rig, watch)
    machine.run(90.0)
    assert set(watch.levels) == {*NAMES, *TEMPERATURES}
    level = watch.levels["pressure_piston_side"]
    assert level.level[1] == pytest.approx(2e5, abs=5e3) and level.level[2] == pytest.approx(-1e5, abs=5e3) and np.isnan(level.level[0])
    machine.run(60.0)
    assert not any(status.opened for status in watch.status())
    shown = machine.run(60.0, departs=4e5)
    opened = [status for status in watch.status() if status.opened]
    assert [status.signal for status in opened] == ["pressure_piston_side"]
    assert opened[0].size == pytest.approx(4e5, rel=0.05) and opened[0].since == pytest.approx(150.0, abs=4.0)
    assert shown.residual[:, PISTON].mean() == pytest.approx(4e5 / level.floor, rel=0.05)
    assert watch.component(watch.status())[0] == "sensor"


@pytest.mark.parametrize(("times", "hidden"), [(1.0, []), (15.0, ["current"])])
def test_a_signal_whose_floor_is_far_beyond_its_noise_hides_gaps(rig, times, hidden):
    watch = GapWatch(rig, SETTINGS)
    machine = Machine(rig, watch)
    machine.noise[NAMES.index("current")] *= times
    machine.run(90.0)
    blunt = watch.blunt()
    assert [name for name in blunt if name in NAMES and name != "pressure_piston_side"] == hidden
    assert all(ratio == pytest.approx(times, rel=0.1) for ratio in (blunt[name] for name in hidden))


def test_a_temperature_that_departs_opens_its_gap(rig):
    watch = GapWatch(rig, SETTINGS)
    machine = Machine(rig, watch)
    machine.run(100.0)
    machine.run(100.0, warmer=4.0)
    assert [status.signal for status in watch.status() if status.opened] == ["temperature/tank_oil"]
    tank = watch.status()[len(NAMES) + TEMPERATURES.index("temperature/tank_oil")]
    assert tank.size == pytest.approx(4.0, abs=0.2) and tank.floor == pytest.approx(np.hypot(0.1, np.hypot(0.5, 0.1)), rel=0.1)


def test_a_rig_that_stands_teaches_nothing_and_is_not_tested(rig):
    watch = GapWatch(rig, SETTINGS)
    Machine(rig, watch, moves=False).run(200.0)
    assert not watch.levels and all(status.learned == 0.0 for status in watch.status())
    working = Machine(rig, watch)
    working.at = 200_000_000_000
    working.run(90.0)
    assert len(watch.levels) == len(NAMES) + len(TEMPERATURES)
    working.moves = False
    before = [status.statistic for status in watch.status()]
    working.run(2.0)
    before = [status.statistic for status in watch.status()]
    working.run(100.0, departs=1e6, warmer=10.0)
    assert [status.statistic for status in watch.status()] == before


@pytest.mark.parametrize("period", [1, 10, 20])
@pytest.mark.parametrize("together", [True, False])
def test_a_slow_temperature_sensor_learns_from_the_bins_in_which_the_rod_moves_between_its_readings(rig, period, together):
    watch, rng = GapWatch(rig, Settings(bin_length=20.0, learning=500.0)), np.random.default_rng(3)
    for k in range(60):
        stamps = 20_000_000_000 * k + TICK * np.arange(1, 401)
        within = (stamps / 1e9) % 20.0
        moves = (within > 11.5) & (within < 15.5) if k % 2 else within < 0.0  # in every other bin
        zero = np.zeros((stamps.size, len(NAMES)))
        read = stamps[(stamps - 9_000_000_000) % (period * 1_000_000_000) == 0]
        reading = 30.0 + 0.1 * rng.standard_normal((stamps.size, len(TEMPERATURES)))
        for part in (slice(None),) if together else (slice(200), slice(200, None)):
            watch.take_hydraulics(stamps[part], zero[part], zero[part], np.where(moves[part], 0.05, 0.0))
            at = np.isin(stamps[part], read)
            watch.take_temperatures(stamps[part][at], reading[part][at], np.full((at.sum(), len(TEMPERATURES)), 30.0))
    learned = {status.learned for status in watch.status()[len(NAMES) :]}
    assert learned == {1.0} and watch.levels[TEMPERATURES[0]].bins == 25


def test_readings_that_come_late_are_left_out_and_no_clock_jump(rig):
    watch = GapWatch(rig, SETTINGS)
    machine = Machine(rig, watch)
    machine.run(100.0)
    shape = (3, len(TEMPERATURES))
    shown, finished = watch.take_temperatures(machine.at - np.array([40, 0, -20]) * TICK, np.full(shape, 90.0), np.full(shape, 30.0))
    assert shown.stamp_ns.size == 0 and finished == 0 and watch.resets == 0
    later = machine.at + TICK * np.arange(1, 41)
    watch.take_hydraulics(later, np.zeros((40, len(NAMES))), np.zeros((40, len(NAMES))), np.full(40, 0.05))
    shown, _ = watch.take_temperatures(later[[19, 9, 39]], np.full(shape, 30.0), np.full(shape, 30.0))
    assert shown.stamp_ns.tolist() == later[[19, 39]].tolist()


def test_the_clock_jumping_back_is_counted_once(rig):
    watch = GapWatch(rig, SETTINGS)
    machine = Machine(rig, watch)
    machine.run(100.0)
    machine.at = 20_000_000_000
    machine.run(10.0)
    assert watch.resets == 1 and not any(status.opened for status in watch.status())
