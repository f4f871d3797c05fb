"""While telemetry comes, temperatures that are in the unit of one that is out of range in it are told, each with a value."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.bags.damage import with_wrong_unit
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.telemetry.recording import Stream
from ddh_twin_py.telemetry.screening.alike_watch import AlikeWatch
from ddh_twin_py.telemetry.screening.screening import StreamScreen, screen_recording
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, ZERO_CELSIUS

SENSORS = ("ambient", "motor_winding", "motor_housing", "tank_oil", "line_a", "line_b")
TOPICS = [TEMPERATURE_PREFIX + name for name in SENSORS]
SECOND = 1_000_000_000
BEGIN = 1_772_000_000 * SECOND


class Live:
    """A watch beside the screens whose topics it looks at."""

    def __init__(self):
        self.screens = {topic: StreamScreen(topic) for topic in ("drive/telemetry", *TOPICS)}
        self.watch = AlikeWatch(self.screens)

    def told(self, celsius, count=20, begin=BEGIN, size=1, apart=0.1):
        """What is told of readings of a unit, two each second and so many at once, and after how many readings of each topic."""
        found = {}
        for start in range(0, count, size):
            for i, topic in enumerate(TOPICS):
                k = np.arange(start, start + size)
                stamp, read = begin + k * SECOND // 2, ZERO_CELSIUS + celsius + apart * i + 0.01 * (k % 3)
                self.watch.take(topic, stamp, read)
                self.screens[topic].screen(stamp, np.column_stack([read, np.zeros(size)]))
            found |= {topic: (start + size, self.watch.refused[topic]) for topic in self.watch.judge()}
        return found


@pytest.mark.parametrize("size", [1, 20])
def test_all_in_degf_are_told_each_with_its_value_with_the_third_reading(size):
    live = Live()
    found = live.told(73.4, size=size)
    assert list(found) == TOPICS[1:] and {when for when, _ in found.values()} == {max(3, size)}
    assert found["temperature/tank_oil"][1] == (
        "temperature looks as if given in degF, expected is degC: it begins with 73.7, as 5 of 5 others do beside temperature/ambient that "
        "is refused as being in degF, with 73.4; not used")
    assert live.told(73.4, begin=BEGIN + 20 * SECOND) == {}, "it is told once"


@pytest.mark.parametrize("celsius", [23.0, 69.0, 296.0, np.nan])
def test_of_what_is_in_range_or_each_out_of_its_own_nothing_is_told_beside(celsius):
    live = Live()
    assert live.told(celsius) == {} and not live.watch.refused


def test_a_warm_unit_beside_an_ambient_in_degf_is_believed():
    assert Live().told(73.4, apart=12.0) == {}


@pytest.mark.parametrize(("back", "believed"), [(3600, True), (5, False)])
def test_at_an_earlier_time_units_are_judged_anew_and_not_where_a_clock_was_put_back_a_little(back, believed):
    live = Live()
    live.told(73.4)
    assert live.told(23.0, begin=BEGIN + (10 - back) * SECOND) == {}
    assert (live.watch.refused == {}) is believed


def test_one_that_goes_over_to_degf_later_says_nothing_of_others_that_began_as_it_did(paper_cycle_bag):
    sound = read_recording(paper_cycle_bag).between(0.0, 60.0)
    late = with_wrong_unit(sound, "temperature/ambient", "temperature", 1.8, ZERO_CELSIUS + 32.0 - 1.8 * ZERO_CELSIUS)
    air, hot = sound.temperatures["ambient"], late.temperatures["ambient"]
    later = np.where((air.time > 30.0)[:, None], hot.values, air.values)
    read = screen_recording(replace(sound, temperatures={**sound.temperatures, "ambient": Stream(air.time, later, air.fields)}))
    assert np.isnan(read.temperatures["ambient"].values[:, 0]).all() and np.isfinite(read.temperatures["tank_oil"].values[:, 0]).all()


def told_of(recording):
    """What is told of a recording that comes a second at a time, and after how many s."""
    screens = {topic: StreamScreen(topic) for topic, _ in recording.streams()}
    watch, found = AlikeWatch(screens), {}
    for second in range(int(recording.duration) + 1):
        for topic, stream in recording.between(second, second + 1.0).streams():
            if len(stream):
                watch.take(topic, stream.stamps(recording.epoch_ns), stream.values[:, 0])
                screens[topic].screen(stream.stamps(recording.epoch_ns), stream.values)
        found |= {topic.removeprefix(TEMPERATURE_PREFIX): (second, watch.refused[topic]) for topic in watch.judge()}
    return found


def test_one_that_is_odd_beside_the_others_is_told_within_half_a_minute_and_no_other(paper_cycle_bag):
    sound = read_recording(paper_cycle_bag).between(0.0, 60.0)
    assert told_of(sound) == {}
    for name, factor, offset, unit in (("motor_winding", 1.8, 32.0 - 0.8 * ZERO_CELSIUS, "degF"),
                                       ("tank_oil", -1.0, 2.0 * ZERO_CELSIUS, "degC of the other sign"),
                                       ("ambient", -1.0, 2.0 * ZERO_CELSIUS, "degC of the other sign")):  # fmt: skip
        found = told_of(with_wrong_unit(sound, f"temperature/{name}", "temperature", factor, offset))
        assert list(found) == [name] and found[name][0] <= 30
        assert found[name][1].startswith(f"temperature looks as if given in {unit}: ") and found[name][1].endswith("; not used")


def test_ambient_and_winding_that_are_exchanged_are_told_once_the_winding_would_be_the_coldest(paper_cycle_bag):
    sound = read_recording(paper_cycle_bag)
    read = sound.temperatures
    assert told_of(sound) == {}
    found = told_of(replace(sound, temperatures={**read, "ambient": read["motor_winding"], "motor_winding": read["ambient"]}))
    assert found.keys() == {"ambient", "motor_winding"} and all("likely exchanged; not used" in text for _, text in found.values())


def test_a_winding_that_is_hot_from_work_is_no_degf_while_slow_air_has_not_told_whether_it_rested(paper_cycle_bag):
    sound = read_recording(paper_cycle_bag).between(0.0, 60.0)
    read = dict(sound.temperatures)
    air = read["ambient"]
    read["ambient"] = Stream(air.time[::10], air.values[::10] - [8.0, 0.0], air.fields)
    winding = read["motor_winding"]
    read["motor_winding"] = Stream(winding.time, winding.values + [60.0, 0.0], winding.fields)
    assert told_of(replace(sound, temperatures=read)) == {}
