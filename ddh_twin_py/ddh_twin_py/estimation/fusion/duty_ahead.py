"""A duty along the temperatures that it leads to.

Cold oil drags: a duty that begins at 23 degC takes half of its current once it has warmed the oil by
10 K. Its losses are therefore worked out anew as the look-ahead goes on, and for each speed at the
temperatures that this speed settles at.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ddh_twin_py.estimation.fusion.look_ahead import LookAhead, Span, step_times
from ddh_twin_py.estimation.fusion.state import FusionState
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.twin.operating_point import OperatingPoint, ScaledDuty

Cost = Callable[[float, np.ndarray], OperatingPoint]
"""Means of a duty at a factor on its speed and node temperatures, K (N,)."""
_FIRST_SPAN = 60.0  # s
_GROWTH = 2.0
ROUNDS = 4
"""Of losses and temperatures that follow from each other."""
_DAMPING = 0.5  # heat falls with temperature nearly as fast as temperature rises with heat: undamped it would swing


def span_ends(horizon: float, most: int | None = None) -> list[float]:
    """Ends of the spans in which the losses are held, s: each twice as long as the one before, ``most`` at most."""
    ends, length = [], _FIRST_SPAN
    while length < horizon:
        ends.append(length)
        length *= _GROWTH
    ends.append(horizon)
    return ends if most is None else ends[max(0, len(ends) - most):]


def warmed(ahead: LookAhead, state: FusionState, cost: Cost, horizon: float, most: int | None = None) -> list[Span]:
    """A duty's spans up to ``horizon`` s, each with the means at the temperature in its middle."""
    temperature, schedule = state.dynamic[:N].copy(), []
    for end in span_ends(horizon, most):
        trial = [*schedule, Span(end, cost(1.0, temperature))]
        after = ahead.mean_temperatures(state, trial, step_times(end))[-1]
        schedule.append(Span(end, cost(1.0, 0.5 * (temperature + after))))
        temperature = ahead.mean_temperatures(state, schedule, step_times(end))[-1]
    return schedule


def settled_speeds(ahead: LookAhead, state: FusionState, cost: Cost, scales: np.ndarray, rounds: int = ROUNDS) -> ScaledDuty | None:
    """A duty at factors ``scales`` (k,) on its speed, each at the temperatures that the unit settles at under it; None without any."""
    if not len(scales):
        return None
    temperature, points = state.dynamic[:N].copy(), []
    for scale in scales:
        for _ in range(rounds):
            temperature += _DAMPING * (ahead.settled_temperatures(state, cost(scale, temperature)) - temperature)
        points.append(cost(scale, temperature))
    return ScaledDuty(scales, points)
