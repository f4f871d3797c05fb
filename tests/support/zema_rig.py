"""A rig like ZeMA's, simulated in steps of 5 ms and read once a second: other equations than the network that diagnoses it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from ddh_twin_py.physics.compiled import kernel

STEP = 0.005
LOAD = ((10, 120.0), (19, 130.0), (29, 140.0), (39, 130.0), (49, 125.0))


@dataclass
class Faults:
    """By cycle, (n,): effectiveness of the cooler, lag of the valve s, orifice in the pump L/min at 155 bar, p_0 V_0 of the gas L bar, air
    degC. Of all cycles: ``jitter`` of the valve, s; ``slack``, share of the pump's slip that knows no viscosity; ``drawn``, how the valve's
    lag grows with the oil's temperature, s/K."""

    effectiveness: np.ndarray
    lag: np.ndarray
    leakage: np.ndarray
    gas: np.ndarray
    air: np.ndarray = field(default=None)
    jitter: float = 0.0005
    slack: float = 0.0
    drawn: float = 0.0


@kernel
def _cycle(p, p2, viscosity, slack, lag, leakage, gas, loads, out):
    """One cycle; pressures before and behind the valve go on from the last one. out: (60, 4) PS1 PS2 FS1 power."""
    out[:] = 0.0
    flow_read = 0.0
    for i in range(int(60.0 / STEP)):
        t = i * STEP
        opened = 1.0
        if t < 30.0:
            shut = (t - 0.05 - lag) / 0.09
            opened = max(0.0, 1.0 - max(shut, 0.0))
            opened = max(opened, min(1.0, max(0.0, (t - 9.12 - lag) / 0.25)))
        load = loads[min(int(t), 59)]
        q_valve = 0.0
        if opened > 0.01:
            drop = p - load
            if drop > 20.0:
                q_valve = opened * 7.85 / 60.0 * (drop - 20.0) / 6.0
        target = load if q_valve > 0.3 / 60.0 else 0.0
        p2 += (target - p2) * STEP / 0.02
        pump = (8.7 - 0.0055 * p * ((1.0 - slack) / viscosity + slack) - leakage * math.sqrt(max(p, 0.0) / 155.0)) / 60.0
        relief = max(0.0, p - 190.0) * 0.08
        stiffness = gas / (p * p) ** 0.995 + 2e-5
        p += STEP * (pump - relief - q_valve) / stiffness
        flow_read += (q_valve * 60.0 - flow_read) * STEP / 0.02
        second = int(t)
        out[second, 0] += p * STEP
        out[second, 1] += p2 * STEP
        out[second, 2] += flow_read * STEP
        out[second, 3] += (300.0 + 13.8 * p) * STEP
    return p, p2


def simulate(faults: Faults, seed: int = 0) -> dict[str, np.ndarray]:
    """Signals (n, 60) of consecutive cycles."""
    rng = np.random.default_rng(seed)
    n = faults.lag.size
    air = 22.0 + np.zeros(n) if faults.air is None else faults.air
    loads = np.zeros(60)
    for begin, value in LOAD:
        loads[begin:] = value
    loads[:10] = 120.0
    loads[0] = 125.0
    names = ("PS1", "PS2", "FS1", "EPS1")
    out = {name: np.empty((n, 60)) for name in names}
    temperatures = np.empty((n, 4))
    p, p2 = 151.0, 125.0
    t1, t3 = 36.0, 39.0
    one = np.empty((60, 4))
    for i in range(n):
        oil = 273.15 + t1 + 2.5
        viscosity = (math.exp(math.exp(22.6 - 3.72 * math.log(oil))) - 0.7) / 42.0
        lag = faults.lag[i] + faults.jitter * rng.standard_normal() + faults.drawn * (t1 - 36.0)
        p, p2 = _cycle(p, p2, viscosity, faults.slack, lag, faults.leakage[i], faults.gas[i], loads, one)
        for j, name in enumerate(names):
            out[name][i] = one[:, j]
        power, cooler = one[:, 3].mean(), 10.15 * 27.0
        for _ in range(30):
            t4 = t3 - faults.effectiveness[i] * (t3 - air[i])
            d1 = (cooler * (t4 - t1) + 470.0 * (t3 - t1)) / 50e3
            d3 = (0.9 * power + (cooler + 470.0) * (t1 - t3) - 8.0 * (t3 - air[i])) / 70e3
            t1, t3 = t1 + 2.0 * d1, t3 + 2.0 * d3
        temperatures[i] = t1, t1 + 0.49 * power / (27.0 * 7.85), t3, t4
    noise = {"PS1": 0.05, "PS2": 0.05, "FS1": 0.01, "EPS1": 3.0}
    for name in names:
        out[name] = np.maximum(out[name] + noise[name] * rng.standard_normal((n, 60)), 0.0)
    for i in range(4):
        out[f"TS{i + 1}"] = temperatures[:, i : i + 1] + 0.04 * rng.standard_normal((n, 60))
    out["FS2"] = 10.15 + 0.02 * rng.standard_normal((n, 60))
    return out
