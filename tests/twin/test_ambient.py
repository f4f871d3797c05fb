"""The air around the unit is smoothed, and followed where its sensor is far off for some readings in a row."""

import numpy as np
import pytest
from ddh_twin_py.twin.ambient import AMBIENT_LAG, MOST_OFF, AmbientTracker
from ddh_twin_py.twin.intervals import INTERVAL

EVERY = 10  # intervals between two readings


def followed(air):
    """What the tracker makes of the air read every 0.5 s, K."""
    read = np.full(air.size * EVERY, np.nan)
    read[::EVERY] = air
    return AmbientTracker(295.0).advance(read)


def test_air_that_warms_quickly_is_followed():
    seconds = np.arange(0.0, 60.0, EVERY * INTERVAL)
    air = 295.0 + 12.0 * np.clip((seconds - 20.0) / 15.0, 0.0, 1.0)
    off = np.repeat(air, EVERY) - followed(air)
    assert 0.5 < off.max() < MOST_OFF + 12.0 / 15.0 * 3.0 * EVERY * INTERVAL


@pytest.mark.parametrize("wild", [1, 2])
def test_one_or_two_wild_readings_are_smoothed(wild):
    air = np.full(60, 295.0)
    air[20: 20 + wild] += 12.0
    assert followed(air).max() - 295.0 < 1.1 * 12.0 * wild * EVERY * INTERVAL / AMBIENT_LAG


def test_noise_is_smoothed_and_the_first_reading_is_believed():
    noise = 0.1 * np.random.default_rng(0).standard_normal(400)
    assert followed(300.0 + noise)[200 * EVERY:].std() < 0.03 and followed(np.full(3, 300.0))[0] == 300.0
