"""Which samples of a recording are of another clock, as the recorder's clock tells: those that live nodes leave out."""

import math

import numpy as np
import pytest
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.clocks.other_clocks import other_clocks
from ddh_twin_py.telemetry.signals import TEMPERATURE_SENSORS

EPOCH = 1_772_000_000_000_000_000
DRIVE, HYDRAULICS = "drive/telemetry", "hydraulics/telemetry"
AIR, OIL, HOUSING = SENSORS = tuple(f"temperature/{name}" for name in ("ambient", "tank_oil", "motor_housing"))
ALL = (DRIVE, HYDRAULICS, *SENSORS)
LASTS = 60.0  # s
ALL_STEP = dict.fromkeys(ALL, (700.0, 20.0, math.inf))


def recorded(topics=ALL, off=(), delay=lambda name, t: 0.0):
    """Stamps of topics and when they came, ns. `off`: by topic how many s its stamps are off, from when on and until when, s."""
    stamps, came, rng = {}, {}, np.random.default_rng(1)
    for k, name in enumerate(topics):
        time = np.arange(0.003 * (k + 1), LASTS, 0.5 if name in SENSORS else 0.02)
        by, since, until = dict(off).get(name, (0.0, 0.0, 0.0))
        stamps[name] = EPOCH + np.rint((time + by * ((time >= since) & (time < until))) * 1e9).astype(np.int64)
        later = rng.uniform(0.5e-3, 2.5e-3, time.size) + [delay(name, t) for t in time.tolist()]
        came[name] = EPOCH + np.rint(np.maximum.accumulate(time + later) * 1e9).astype(np.int64)
    return stamps, came


def left_out_live(stamps, came):
    """Numbers of the samples, by topic, that no tick of a live node tells."""
    aligner = TickAligner(dict.fromkeys(stamps, 1), timeout=2.0, awaited=[DRIVE, HYDRAULICS])
    missing = {name: set(range(stamp.size)) for name, stamp in stamps.items()}

    def take(ticks):
        for tick in ticks:
            for name, samples in tick.samples.items():
                missing[name] -= set(samples.values[:, 0].astype(int).tolist())

    for _, name, i in sorted((at, name, i) for name, times in came.items() for i, at in enumerate(times.tolist())):
        aligner.push(name, int(stamps[name][i]), [float(i)])
        take(aligner.ready())
    take(aligner.flush())
    return {name: sorted(numbers) for name, numbers in missing.items() if numbers}


@pytest.mark.parametrize("until", [40.0, math.inf])
@pytest.mark.parametrize("by", [-700.0, -60.0, -4.0, 5.0, 60.0, 700.0])
@pytest.mark.parametrize(("topics", "alone"), [(ALL, DRIVE), (ALL, HYDRAULICS), (ALL, OIL), ((DRIVE, HYDRAULICS), DRIVE)])
def test_a_clock_that_steps_alone_is_left_out_as_live(topics, alone, by, until):
    stamps, came = recorded(topics, {alone: (by, 20.0, until)})
    ((topic, (here, ahead)),) = other_clocks(stamps, came).items()
    assert topic == alone and ahead == pytest.approx(by * 1e9, abs=0.1e9)
    live = left_out_live(stamps, came)
    voted = np.count_nonzero(came[alone] < EPOCH + round((LASTS - 1.0) * 1e9))  # of what comes at the very end live nodes have no time to
    assert live.keys() == {alone} and [i for i in live[alone] if i < voted] == np.flatnonzero(here[:voted]).tolist()


@pytest.mark.parametrize("by", [-700.0, -60.0, 60.0, 700.0])
@pytest.mark.parametrize("alone", ALL)
def test_a_clock_that_is_off_from_the_begin_is_left_out_until_it_is_right(alone, by):
    for until in (30.0, math.inf):
        stamps, came = recorded(off={alone: (by, 0.0, until)})
        ((topic, (here, ahead)),) = other_clocks(stamps, came).items()
        off = stamps[alone] != recorded()[0][alone]
        assert topic == alone and ahead == pytest.approx(by * 1e9, abs=0.1e9) and np.array_equal(here, off)


def of_one_logger(by, since=0.0):
    """Stamps and arrivals where all temperatures are of a logger whose clock is so many s off from then on."""
    names = tuple(f"temperature/{name}" for name in TEMPERATURE_SENSORS)
    return recorded((DRIVE, HYDRAULICS, *names), dict.fromkeys(names, (by, since, math.inf)))


@pytest.mark.parametrize("since", [0.0, 20.0])
@pytest.mark.parametrize("by", [-700.0, -60.0, 60.0])
def test_many_sensors_of_one_logger_do_not_outvote_a_machine_that_goes_by_the_recorders_clock(by, since):
    stamps, came = of_one_logger(by, since)
    found = other_clocks(stamps, came)
    assert found.keys() == {name for name in stamps if name.startswith("temperature/")}
    for name, (here, ahead) in found.items():
        assert ahead == pytest.approx(by * 1e9, abs=0.1e9) and np.array_equal(here, came[name] > EPOCH + since * 1e9)


def test_many_topics_outvote_one_sensor_though_it_goes_by_the_recorders_clock():
    stamps, came = recorded(off={name: (60.0, 0.0, math.inf) for name in ALL if name != OIL})
    assert other_clocks(stamps, came).keys() == {OIL}


def test_two_that_step_one_after_the_other_cost_the_rest_nothing():
    stamps, came = recorded((DRIVE, HYDRAULICS, AIR), {DRIVE: (60.0, 10.0, 30.0), AIR: (-90.0, 20.0, 45.0)})
    found = other_clocks(stamps, came)
    assert HYDRAULICS not in found and found[DRIVE][0].sum() == 1000


def test_one_stamp_that_its_topic_does_not_go_on_from_is_left_out():
    for by in (-60.0, 60.0):
        stamps, came = recorded(off={OIL: (by, 20.0, 20.5)})
        assert other_clocks(stamps, came)[OIL][0].sum() == 1


def test_a_topic_without_messages_is_no_clock():
    nothing = np.empty(0, np.int64)
    assert other_clocks({OIL: nothing}, {OIL: nothing}) == {}


def late(name, t):
    return 3.0 if name == OIL and 20.0 < t < 20.5 else 0.0


def stored(name, t):
    """One topic's messages of ten seconds come at once."""
    return 30.0 - t if name == HYDRAULICS and 20.0 < t < 30.0 else 0.0


@pytest.mark.parametrize("delay", [
    late, stored, lambda name, t: 6.0 * (name == OIL), lambda name, t: math.ceil(t / 3.0) * 3.0 - t, lambda name, t: 8.0 * (t > 20.0),
], ids=["late", "stored", "lags", "bursts", "held up"])  # fmt: skip
@pytest.mark.parametrize("off", [{}, ALL_STEP, dict.fromkeys(ALL, (-60.0, 20.0, math.inf))], ids=["even", "ahead", "back"])
def test_what_comes_late_is_of_no_other_clock(off, delay):
    assert other_clocks(*recorded(off=off, delay=delay)) == {}


def test_one_against_one_from_the_begin_is_open():
    assert other_clocks(*recorded((DRIVE, HYDRAULICS), {DRIVE: (60.0, 0.0, math.inf)})) == {}


def copies(stamps, came):
    return {name: np.maximum.accumulate(stamp + 1_000_000) for name, stamp in stamps.items()}


def alike(stamps, came):
    return {name: np.full_like(at, EPOCH) for name, at in came.items()}


def ten_times(stamps, came):
    return {name: EPOCH + (at - EPOCH) // 10 for name, at in came.items()}


def set_back(stamps, came):
    return {name: at - 30_000_000_000 * (at > EPOCH + 30_000_000_000) for name, at in came.items()}


@pytest.mark.parametrize("clock", [copies, alike, ten_times, set_back])
@pytest.mark.parametrize("by", [-700.0, -30.0, 60.0])
@pytest.mark.parametrize("since", [0.0, 20.0])
def test_a_recorders_clock_that_tells_nothing_is_not_believed(clock, by, since):
    stamps, came = recorded(off={DRIVE: (by, since, math.inf)})
    assert other_clocks(stamps, came)
    assert other_clocks(stamps, clock(stamps, came)) == {}
