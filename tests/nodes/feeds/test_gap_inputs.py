"""What gap_monitor takes of stamps that step back and of estimates that are no numbers, before the gap watch sees them."""

import numpy as np
import pytest
from ddh_twin_py.gap.watch.watch import HYDRAULIC, GapWatch, Settings
from ddh_twin_py.nodes.base.times import set_time
from ddh_twin_py.nodes.feeds.gap_inputs import ESTIMATE_TOPIC, READING_TOPIC, RESIDUAL_TOPIC, Forward, FreeRunResiduals, FreeRunTemperatures
from ddh_twin_py.nodes.messages.conversion import FREE_RUN
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.temperature_sensors import SENSORS
from rclpy.serialization import serialize_message

from ddh_msgs.msg import ResidualArray, TemperatureEstimate, TemperatureEstimateArray

TICK = 50_000_000


def watched(step, learned=60.0):
    """A watch after so many s of work, and a clock that steps then by so many s, 30 s more; and what kept it going forward."""
    watch, forward, rng = GapWatch(load_rig(None), Settings(bin_length=1.0, learning=100.0)), Forward(), np.random.default_rng(1)
    for begin, count in ((0, round(learned * 20)), (round((learned + step) * 20), 600)):
        for first in range(begin, begin + count, 7):
            stamps = TICK * np.arange(first + 1, first + 8)
            used = forward.used(stamps)
            residual, phase = rng.standard_normal((7, len(HYDRAULIC))), np.full(7, 0.05)
            watch.take_hydraulics(stamps[used], residual[used], 0.0 * residual[used], phase[used])
    return watch, forward


@pytest.mark.parametrize("step", [-1.0, -5.0, -10.0])
def test_a_clock_put_back_a_little_costs_no_more_than_it_was_put_back_by(step):
    steady = watched(0.0)[0].status()[0].learned
    watch, forward = watched(step)
    assert (watch.resets, forward.put_back) == (0, 1)
    assert steady + (step - 1.0) / 100.0 <= watch.status()[0].learned < steady


def test_an_earlier_time_begins_anew():
    watch, forward = watched(-30.0)
    assert (watch.resets, forward.put_back) == (1, 0)
    assert watch.status()[0].learned == pytest.approx(0.29, abs=0.02)


def test_a_step_within_a_run_is_found():
    forward = Forward()
    assert forward.used(np.array([1, 2, 3, 2, 3, 4]) * 1_000_000_000).tolist() == [True, True, True, False, True, True]
    assert forward.used(np.array([3, 4, 5, 6]) * 1_000_000_000).tolist() == [False, True, True, True]
    assert forward.put_back == 2


def estimates(tick, predicted):
    """The message of a tick, every node predicted at so many degC."""
    message = TemperatureEstimateArray(estimates=[TemperatureEstimate(location=node, predicted=predicted) for node in NODES])
    set_time(message.header.stamp, tick * TICK)
    return serialize_message(message)


def test_an_estimate_that_is_no_number_costs_itself_alone():
    taken = FreeRunTemperatures(np.full(len(SENSORS), 1.0), 0.5)
    taken.take_estimates([estimates(tick, np.nan if tick in (4, 5) else 30.0) for tick in range(1, 11)])
    assert [tick for tick in range(1, 11) if tick * TICK in taken._expected] == [1, 2, 3, 6, 7, 8, 9, 10]


@pytest.mark.parametrize("batch", [2, 5, 40])
def test_what_sensors_read_of_the_free_run_does_not_depend_on_how_estimates_are_batched(batch):
    def expected(size):
        taken = FreeRunTemperatures(np.full(len(SENSORS), 5.0), 0.5)
        taken.take_estimates([estimates(80, 30.0)])  # of a time before, which ends here
        for first in range(1, 41, size):
            taken.take_estimates([estimates(tick, 30.0 + 0.1 * tick) for tick in range(first, min(first + size, 41))])
        return np.array([taken._expected[tick * TICK] for tick in range(1, 41)])

    np.testing.assert_allclose(expected(batch), expected(1), rtol=0.0, atol=1e-9)


def test_messages_that_are_cut_off_are_counted_by_topic():
    residuals, temperatures = FreeRunResiduals(), FreeRunTemperatures(np.full(len(SENSORS), 1.0), 0.5)
    cut = serialize_message(ResidualArray(source=FREE_RUN))[:-4]
    assert residuals.parse([cut, cut]) == temperatures.parse([cut[:20]]) == []
    assert temperatures.take_estimates([estimates(1, 30.0)[:100], estimates(2, 30.0)]) == 2 * TICK
    left_out = {topic: parser.unreadable for topic, parser in (residuals.parsers | temperatures.parsers).items()}
    assert left_out == {RESIDUAL_TOPIC: 2, READING_TOPIC: 1, ESTIMATE_TOPIC: 1}
