"""What the fusion takes of its ticks, and what it tells the look-ahead of them."""

import numpy as np
from ddh_twin_py.nodes.feeds.fusion_inputs import MOTOR_TOPIC, MOTOR_WIDTH, STATE_TOPIC, STATE_WIDTH, add_duty, asked_of, inputs_of
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.ticks import Samples, Tick
from ddh_twin_py.twin.operating_point import PresentDuty

INTERVAL_NS = 50_000_000


def tick(k, *topics):
    """A tick with one row of ones from each of these models."""
    widths = {STATE_TOPIC: STATE_WIDTH, MOTOR_TOPIC: MOTOR_WIDTH}
    samples = {
        topic: Samples(np.full(int(topic in topics), (k + 1) * INTERVAL_NS, np.int64), np.ones((int(topic in topics), width)))
        for topic, width in widths.items()
    }
    return Tick(k * INTERVAL_NS, (k + 1) * INTERVAL_NS, k == 0, samples)


def test_only_ticks_in_which_both_models_spoke_are_duty():
    ticks = [tick(0), tick(1, STATE_TOPIC, MOTOR_TOPIC), tick(2, MOTOR_TOPIC), tick(3, STATE_TOPIC)]
    inputs, _ = inputs_of(ticks)
    assert inputs.hydraulics_known.tolist() == [False, True, False, True] and inputs.motor_known.tolist() == [False, True, True, False]
    present = PresentDuty(load_rig(), 0.05)
    add_duty(present, asked_of([ticks[0], ticks[2]]), inputs_of([ticks[0], ticks[2]])[0])
    assert not present.known
    add_duty(present, asked_of(ticks), inputs)
    assert present.known and present.point().mean_square_current == 1.0


def test_a_restart_may_find_a_tick_in_which_one_model_has_not_spoken():
    for topic in (STATE_TOPIC, MOTOR_TOPIC):
        ticks = [tick(0, topic), tick(1, STATE_TOPIC, MOTOR_TOPIC), tick(2, topic)]
        present, (inputs, _) = PresentDuty(load_rig(), 0.05), inputs_of(ticks)
        add_duty(present, asked_of(ticks), inputs)
        assert sum(rows[3].size for rows in present._rows) == 1
        assert (inputs.hydraulics_known & inputs.motor_known).tolist() == [False, True, False]
