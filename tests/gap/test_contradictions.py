"""Channels that cannot all be right are told, and sound recordings are not suspected."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.contradictions import contradictions
from ddh_twin_py.rig import load_rig
from support.simulated import simulated


@pytest.fixture(scope="module")
def recording():
    return simulated(1, "mixed", 120.0)[0]


def changed(recording, stream, change):
    own = getattr(recording, stream)
    values = own.values.copy()
    change(values, own.fields.index)
    return replace(recording, **{stream: replace(own, values=values)})


def later(recording, seconds):
    return replace(recording, hydraulic=replace(recording.hydraulic, time=recording.hydraulic.time + seconds))


def flipped(values, at):
    values[:, at("rod_position")] = 0.4 - values[:, at("rod_position")]


def reversed_rod(values, at):
    flipped(values, at)
    values[:, at("rod_velocity")] *= -1.0


def reversed_current(values, at):
    values[:, at("current")] *= -1.0


def swapped(values, at):
    one, other = at("pressure_piston_side"), at("pressure_rod_side")
    values[:, [one, other]] = values[:, [other, one]]


def test_a_sound_recording_is_not_suspected(recording):
    assert contradictions(recording, load_rig()) == []
    assert contradictions(later(recording, 0.1), load_rig()) == []


@pytest.mark.parametrize(("stream", "change", "said"), [
    ("hydraulic", flipped, "one of them counts from the other end"), ("hydraulic", reversed_rod, "has the wrong sign"),
    ("drive", reversed_current, "its sign is likely the wrong one"), ("hydraulic", swapped, "connectors are likely swapped"),
])  # fmt: skip
def test_what_cannot_be_is_told(recording, stream, change, said):
    found = contradictions(changed(recording, stream, change), load_rig())
    assert len(found) == 1 and said in found[0] and recording.path in found[0] and "/telemetry" in found[0]


@pytest.mark.parametrize(("seconds", "said"), [(2.0, "2.0 s earlier"), (-1.5, "1.5 s later")])
def test_clocks_that_differ_are_told(recording, seconds, said):
    assert [said in text for text in contradictions(later(recording, seconds), load_rig())] == [True]


def test_what_is_missing_or_stands_still_tells_nothing(recording):
    assert contradictions(replace(recording, hydraulic=None), load_rig()) == []
    still = changed(recording, "drive", lambda values, at: values.fill(0.0))
    assert contradictions(changed(still, "hydraulic", lambda values, at: values.fill(np.nan)), load_rig()) == []
