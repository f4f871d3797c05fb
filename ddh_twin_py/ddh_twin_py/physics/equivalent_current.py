"""The paper's equivalent current (equation 6), and how far it can be trusted.

i(t) = I_M cos(W t + theta), so that i^2 has the mean I_M^2/2; the paper calls that mean I_heat, although it is the
square of a current. A motor that is fed the constant current sqrt(I_M^2/2) makes the same copper heat in the mean.
It holds as long as the winding's temperature stays nearly even over a cycle: heat ripples twice in a
cycle, and the winding follows the more, the longer the cycle is against its time constant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.physics.motor_geometry import ZERO_CELSIUS, Load, Network, NoSteadyState


def mean_square(amplitude: float) -> float:
    """Mean of the squared current, A^2: I_M^2/2 (paper, eq. 6: its I_heat), I_M the largest rms phase current, A."""
    return 0.5 * amplitude**2


def equivalent_current(amplitude: float) -> float:
    """Constant rms current, A, that makes the same copper heat: I_M/sqrt(2); ``amplitude`` I_M, the largest rms phase current, A."""
    return math.sqrt(mean_square(amplitude))


def ripple(period: float, time_constant: float) -> float:
    """Largest excess of a first-order winding's rise over its mean, as a share of the mean rise.

    Heat is P (1 + cos 2Wt), so the rise is P R (1 + cos(2Wt - phi)/sqrt(1 + (2 W tau)^2)), W = 2 pi/period.
    0 for a cycle that is short against the time constant, 1 for one that is long: the paper's constant
    current then misses half of the largest rise. Constant resistance. ``period`` and ``time_constant`` tau in s.
    """
    return 1.0 / math.hypot(1.0, 4.0 * math.pi * time_constant / period)


@dataclass(frozen=True)
class Comparison:
    """Time-resolved solution against the equivalent current, after the cycles have repeated themselves.

    Attributes:
        period: s. current: amplitude, A.
        steady: temperatures with the equivalent current, K: mean of the slot winding.
        mean, largest: of the slot winding over one cycle, time-resolved, K.
        steady_loss, mean_loss: copper loss, W.
    """

    period: float
    current: float
    steady: float
    mean: float
    largest: float
    steady_loss: float
    mean_loss: float


def compare(network: Network, amplitude: float, period: float, load: Load, steps: int = 64, cycles: int = 2) -> Comparison:
    """Run cosine cycles to their repeating state and compare with the constant equivalent current.

    The run starts from the equivalent current's steady state; what is left of slow drifts is taken out by `repeating`.

    Args:
        network: of the motor. amplitude: largest rms phase current, A. period: s.
        load: speed and ambient. steps: per period. cycles: per round of `repeating`.
    """
    constant = Load(equivalent_current(amplitude), load.speed, load.ambient)
    steady = network.steady(constant)
    state = repeating(network, lambda t: Load(amplitude * math.cos(2.0 * math.pi * t / period), load.speed, load.ambient),
                      period, steady, steps, cycles)
    winding = state @ _weights(network)
    time = np.linspace(0.0, period, steps + 1)
    squares = np.square(amplitude * np.cos(2.0 * math.pi * time / period))
    return Comparison(
        period, amplitude, float(steady @ _weights(network)), float(np.trapezoid(winding, time) / period), float(winding.max()),
        _copper(network, steady, constant.current**2),
        float(np.trapezoid([_copper(network, t, s) for t, s in zip(state, squares, strict=True)], time) / period),
    )


def repeating(
    network: Network, load: Callable[[float], Load], period: float, start: np.ndarray, steps: int, cycles: int, rounds: int = 12
) -> np.ndarray:
    """Temperatures over one period, (steps + 1, n), K, once they repeat to 1 mK.

    A round is the map of a temperature field to the one some cycles later; its fixed point is found with Anderson's
    acceleration (J. ACM 12 (1965) 547), since the housing alone would take hours of cycles to settle.

    Args:
        network: of n nodes. load: of a time in s, periodic. period: s. start: K, (n,). steps: per period.
        cycles: per round. rounds: at most.

    Raises:
        NoSteadyState: where they do not repeat after `rounds`.
    """
    time = np.linspace(0.0, period, steps + 1)
    states, results = [], []
    state = start
    for _ in range(rounds):
        end = state
        for _ in range(cycles):
            run = network.transient(time, load, end)
            end = run[-1]
        states.append(state)
        results.append(end)
        if np.abs(run[-1] - run[0]).max() < 1e-3 and np.abs(end - state).max() < 1e-3:
            return run
        misses = np.array([r - s for r, s in zip(results, states, strict=True)])
        if len(misses) > 1:
            weights = np.linalg.lstsq((misses[1:] - misses[:-1]).T, misses[-1], rcond=None)[0]
            change = np.diff(np.array(results), axis=0)
            state = end - weights @ change
        else:
            state = end
    raise NoSteadyState(f"temperatures of a cycle of {period:g} s do not repeat after {rounds} rounds")


def _weights(network: Network) -> np.ndarray:
    chosen = (network.part == "slot_winding") * network.capacity
    return chosen / chosen.sum()


def _copper(network: Network, temperature: np.ndarray, square: float) -> float:
    factor = 1.0 + network.rig["motor.copper_temperature_coefficient"] * (temperature - ZERO_CELSIUS - 20.0)
    return float(square * (network.copper @ factor))
