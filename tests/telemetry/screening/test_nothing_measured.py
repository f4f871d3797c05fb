"""Topics that tell nothing but zeros, and variances that no sensor has."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.replay import ReplayError, replay
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.recording import Stream
from ddh_twin_py.telemetry.screening.screening import screen_recording
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC


@pytest.fixture(scope="module")
def moving(paper):
    return paper.between(0.0, 20.0)


def zeroed(recording, *topics):
    """All values of some topics are 0."""
    return recording.with_streams({name: Stream(s.time, 0.0 * s.values, s.fields) if name in topics else s
                                   for name, s in recording.streams()})


@pytest.mark.parametrize("topic, says", [(DRIVE_TOPIC, "the rod moves by"), (HYDRAULIC_TOPIC, "the shaft's speed goes over")])
def test_zeros_are_not_used_where_the_other_moves(moving, noise, topic, says):
    screened = screen_recording(zeroed(moving, topic), noise)
    (finding,) = screened.findings
    assert (finding.severity, finding.topic, finding.value) == ("error", f"/ddh/{topic}", 0.0)
    assert f"/ddh/{topic}: all fields are exactly 0 in all {finding.count} samples, and {says}" in finding.message
    streams = dict(screened.streams())
    assert np.isnan(streams[topic].values).all() and all(np.isfinite(s.values).all() for name, s in streams.items() if name != topic)


def test_a_drive_of_zeros_is_refused_with_the_reason(moving):
    with pytest.raises(ReplayError, match=r"refused in all of \d+ messages; .* current; /ddh/drive/telemetry: all fields are exactly 0"):
        replay(zeroed(moving, DRIVE_TOPIC), load_rig())


def test_zeros_of_both_are_asked_after_and_those_of_a_resting_drive_are_right(moving, noise):
    screened = screen_recording(zeroed(moving, DRIVE_TOPIC, HYDRAULIC_TOPIC), noise)
    (finding,) = screened.findings
    assert finding.severity == "warning" and finding.topic == f"/ddh/{HYDRAULIC_TOPIC}" and not screened.hydraulic.values.any()
    rests = np.repeat(moving.hydraulic.values[:1], len(moving.hydraulic), axis=0)
    rests += np.random.default_rng(1).normal(size=rests.shape) * [2e4, 2e4, 2e-4, 1.5e-3]
    resting = zeroed(replace(moving, hydraulic=replace(moving.hydraulic, values=rests)), DRIVE_TOPIC)
    assert screen_recording(resting, noise).findings == []


@pytest.mark.parametrize("variance", [1e12, -4.0, np.inf])
def test_a_variance_that_no_sensor_has_is_a_remark(moving, noise, variance):
    oil = moving.temperatures["tank_oil"]
    told = replace(oil, values=np.column_stack([oil.values[:, 0], np.full(len(oil), variance)]))
    screened = screen_recording(replace(moving, temperatures={**moving.temperatures, "tank_oil": told}), noise)
    (finding,) = screened.findings
    assert (finding.severity, finding.topic, finding.value) == ("info", "/ddh/temperature/tank_oil", variance)
    assert f"variance is {variance:.4g} K2" in finding.message and finding.count == len(oil)
    assert np.array_equal(screened.temperatures["tank_oil"].column("temperature"), oil.column("temperature"))
