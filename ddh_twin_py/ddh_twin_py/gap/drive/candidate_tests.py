"""Tests that a unit could be asked to do next: short duties that work its parts differently, within what its drive can hold."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import END_WINDING, TANK
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.duty import Duty, Segment
from ddh_twin_py.twin.possible_speed import highest_speed

LENGTH = 180.0
"""s of one test."""
SLOWEST, FASTEST = 200.0, 1500.0
"""rpm between which tests drive."""
LIGHT, HEAVY = 0.5, 1.6
"""Payloads in multiples of the declared one."""
LEAST_WARM = 3.0
"""K of winding or tank oil above ambient from which a start counts as warm."""
_SHARE = 0.9  # of the highest speed that can be held
_RAMP = 1150.0 * RAD_PER_S_OF_RPM
_LOW, _HIGH = 0.05, 0.925  # of the stroke


@dataclass(frozen=True)
class CandidateTest:
    """A test that could be made.

    Attributes:
        duty: what is done for `LENGTH` s. start: temperatures of all nodes, K, (N,); None is ambient.
        words: what it is, with numbers.
    """

    duty: Duty
    start: np.ndarray | None
    words: str


def candidate_tests(rig: Rig, payload: float, ambient: float, warm: np.ndarray) -> list[CandidateTest]:
    """Tests of `LENGTH` s; the first is the usual one. Those that the drive cannot hold are slower or left out,
    and none is left where it can hold none of them.

    Args:
        rig: as known. payload: declared, kg. ambient: K. warm: temperatures that the recorded duty ended with, K, (N,).
    """
    light, heavy = _rounded(LIGHT * payload), _rounded(HEAVY * payload)
    cold = np.full(warm.size, ambient)
    is_warm = max(warm[END_WINDING], warm[TANK]) - ambient >= LEAST_WARM
    wanted = [  # payload, rpm up, rpm down, dwell s, from, to, warm
        (payload, 500.0, 500.0, 2.0, _LOW, _HIGH, False),
        (payload, SLOWEST, SLOWEST, 2.0, _LOW, _HIGH, False),
        (payload, 1200.0, 1200.0, 1.0, _LOW, _HIGH, False),
        (payload, 900.0, SLOWEST, 2.0, _LOW, _HIGH, False),
        (payload, SLOWEST, 900.0, 2.0, _LOW, _HIGH, False),
        (payload, 500.0, 500.0, 30.0, _LOW, _HIGH, False),
        (payload, 600.0, 600.0, 0.5, 0.4, 0.6, False),
        (light, 500.0, 500.0, 2.0, _LOW, _HIGH, False),
        (light, 1200.0, 1200.0, 1.0, _LOW, _HIGH, False),
        (heavy, 400.0, 400.0, 2.0, _LOW, _HIGH, False),
        (heavy, 900.0, 900.0, 1.0, _LOW, _HIGH, False),
    ]
    if is_warm:
        wanted += [(payload, 500.0, 500.0, 2.0, _LOW, _HIGH, True), (payload, 500.0, 500.0, 60.0, _LOW, _HIGH, True)]
    found: dict[str, CandidateTest] = {}
    for load, up, down, dwell, low, high, begun_warm in wanted:
        start = warm if begun_warm else cold
        loaded = rig.declaring(load)
        up, down = _held(loaded, start, 1.0, up), _held(loaded, start, -1.0, down)
        if up is None or down is None:
            continue
        bottom, top = low * rig["cylinder.stroke"], high * rig["cylinder.stroke"]
        duty = Duty(load, np.zeros(1), np.array([ambient]), bottom, _RAMP, 0, (
            Segment("dwell", 0.0, 0.0, dwell), Segment("lift", up * RAD_PER_S_OF_RPM, top, 60.0),
            Segment("dwell", 0.0, 0.0, dwell), Segment("lower", down * RAD_PER_S_OF_RPM, bottom, 60.0)), "candidate test")
        words = (f"{LENGTH / 60.0:g} min of lifting {load:g} kg at {up:g} rpm and lowering it at {down:g} rpm between {bottom:.2f} and "
                 f"{top:.2f} m, with {dwell:g} s of rest at each end, begun {_begun(start, ambient)}")
        found.setdefault(words, CandidateTest(duty, start if begun_warm else None, words))
    return list(found.values())


def _begun(start: np.ndarray, ambient: float) -> str:
    if np.all(start == ambient):
        return f"with the unit as cold as its surroundings ({ambient - ZERO_CELSIUS:.0f} degC)"
    return (f"right after a duty such as the recorded one, while the tank oil is at {start[TANK] - ZERO_CELSIUS:.0f} degC and the winding "
            f"at {start[END_WINDING] - ZERO_CELSIUS:.0f} degC")


def _rounded(payload: float) -> float:
    """kg, to 5 kg, or to two figures where it is small."""
    return max(5.0 * round(payload / 5.0), float(f"{payload:.2g}") if payload < 10.0 else 5.0)


def _held(rig: Rig, temperature: np.ndarray, sign: float, wanted: float) -> float | None:
    """The wanted speed, rpm, or the most that the drive can hold, rounded down to 50 rpm; None below `SLOWEST`."""
    top, _ = highest_speed(rig.parameters, np.ascontiguousarray(temperature), sign, FASTEST * RAD_PER_S_OF_RPM, _RAMP, np.empty(6))
    possible = 50.0 * math.floor(_SHARE * top / RAD_PER_S_OF_RPM / 50.0)
    return min(wanted, possible) if possible >= SLOWEST else None
