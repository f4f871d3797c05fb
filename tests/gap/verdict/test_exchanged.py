"""Sensors that read each other's places."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.binning import by_time
from ddh_twin_py.estimation.fitting.experiment import Signal
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.verdict.exchanged import PROBABILITY, Exchanged, exchanged, first_of_both

TIME = np.arange(0.0, 300.0, 1.0)
COURSES = {"temperature/housing": 300.0 + 8.0 * (1.0 - np.exp(-TIME / 200.0)), "temperature/case": 300.0 + 0.02 * TIME,
           "temperature/tank": 300.0 + 0.01 * TIME}


def case(read):
    """A model whose field recording reads these courses, with noise, and whose twin expects `COURSES`; and what a fit leaves there."""
    rng = np.random.default_rng(1)
    signals = {name: Signal(TIME, course + rng.normal(0.0, 0.1, TIME.size), 0.1, "K", by_time(TIME, np.ones(TIME.size, bool), 20.0))
               for name, course in read.items()}
    return SimpleNamespace(altered=[False, True], signals=[{}, signals], run_one=lambda number, theta, acting: COURSES)


def fitted(**courses):
    return SimpleNamespace(predictions=[{}, {**COURSES, **courses}])


SWAPPED = {**COURSES, "temperature/housing": COURSES["temperature/case"], "temperature/case": COURSES["temperature/housing"]}


def test_two_sensors_that_read_each_other_s_places_are_exchanged():
    found = exchanged(case(SWAPPED), np.zeros(1), fitted())
    assert found.signals == ("temperature/housing", "temperature/case") and found.own > 5.0 > 1.2 > found.other
    assert found.said.endswith("are the two sensors exchanged?") and "temperature/case" in found.said


def test_a_recording_without_a_reading_takes_nothing_off():
    one, silent = case(SWAPPED), case(dict.fromkeys(COURSES, np.full(TIME.size, np.nan)))
    both = SimpleNamespace(altered=[False, True, True], signals=[{}, one.signals[1], silent.signals[1]], run_one=one.run_one)
    fit = SimpleNamespace(predictions=[{}, COURSES, COURSES])
    assert exchanged(both, np.zeros(1), fit) == exchanged(one, np.zeros(1), fit)
    assert exchanged(silent, np.zeros(1), fit) is None


@pytest.mark.parametrize("read", [
    COURSES,
    {**COURSES, "temperature/housing": COURSES["temperature/housing"] + 3.0},  # one alone
    dict.fromkeys(COURSES, 0.5 * (COURSES["temperature/housing"] + COURSES["temperature/case"])),  # heat flows between them
])  # fmt: skip
def test_heat_and_single_sensors_are_no_exchange(read):
    assert exchanged(case(read), np.zeros(1), fitted()) is None


def test_what_the_leader_explains_far_better_is_no_exchange():
    drifted = {**SWAPPED, "temperature/tank": COURSES["temperature/tank"]}
    blurred = {name: course + 0.3 * np.sin(TIME / 30.0) for name, course in drifted.items()}
    assert exchanged(case(blurred), np.zeros(1), fitted(**blurred)) is None
    assert exchanged(case(blurred), np.zeros(1), fitted()) is not None


def test_the_reading_that_errs_is_the_first_place():
    found = Exchanged(("temperature/housing", "temperature/case"), 9.0, 1.0)
    motor = FreePlace("motor", "thermal", 9.0, 0.6, None)
    sensor = replace(motor, component="sensor", domain="measurement", share=0.4, signal="temperature/case")
    first, second = first_of_both(found, [motor, sensor])
    assert (first.component, first.share, second.component) == ("sensor", PROBABILITY, "motor")
    assert second.share == pytest.approx(1.0 - PROBABILITY) and first_of_both(found, [motor]) == [motor]
