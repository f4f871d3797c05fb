"""What the network says of a whole record, with every component in its best condition and with the conditions found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ddh_twin_py.real_rigs.zema import network
from ddh_twin_py.real_rigs.zema.conditions import COMPONENTS, Conditions
from ddh_twin_py.real_rigs.zema.features import Features


def with_conditions(f: Features, p: np.void, conditions: Conditions | None = None) -> dict[str, np.ndarray]:
    """Signals by the network, shapes as in `network.predict`; temperatures run free from the first, hydraulics with the oil as read.

    Args:
        p: parameter record fitted to the known cycles. conditions: expected ones of each cycle, with the pump's slip and the accumulator's
            best level as the record shows them; None is the best throughout.
    """
    n = f.power.size
    shift, lag = {component: np.zeros(n) for component in COMPONENTS}, np.zeros((n, 2))
    if conditions is not None:
        shift = {component: one.expected for component, one in conditions.found.items()}
        shift["pump_leakage"] = shift["pump_leakage"] + conditions.found["pump_leakage"].explained
        shift["accumulator"] = shift["accumulator"] + np.median(conditions.found["accumulator"].base)
        lag = shift["valve"][:, None] * conditions.direction
    gas = float(p["gas"]) * np.exp(shift["accumulator"])
    oil = 0.5 * (f.temperature[:, 0] + f.temperature[:, 1])
    leak = shift["pump_leakage"][:, None] * np.sqrt(np.maximum(f.pressure, 0.0) / network.AT_LEAK)
    closing = float(p["closing"]) + lag[:, 0]
    best = float(p["effectiveness"])
    effectiveness = best if conditions is None or conditions.estimate["cooler"] is None else np.clip(best + shift["cooler"], 0.0, 1.0)
    temperatures = network.temperatures(f, p, effectiveness * np.ones(n))
    return {**{f"temperature/TS{i + 1}": temperatures[:, i] for i in range(4)}, "flow": network.flows(f, oil, p) - leak,
            "stored": gas[:, None] * network.stored(f), "closing": np.stack([closing, closing + float(p["flow_late"])], axis=1),
            "opening": float(p["opening"]) + lag[:, 1],
            "rise": closing + float(p["rise_late"]) + float(p["rise_ratio"]) * gas * network.rise(f)}


def simulated(f: Features, p: np.void, noise: dict[str, float], seed: int) -> Features:
    """Features as a rig would give them that is the network, at the same loads and oil, every component in its best condition.

    Args:
        noise: standard deviation of each signal's numbers, white; of the cooler's outlet as ``temperature``.
    """
    rng = np.random.default_rng(seed)
    said = with_conditions(f, p)
    read = {name: said[name] + rng.normal(0.0, noise[name], said[name].shape) for name in ("flow", "stored", "closing", "opening", "rise")}
    outlet = f.temperature[:, 2] - float(p["effectiveness"]) * (f.temperature[:, 2] - float(p["air"]))
    temperature = np.column_stack([f.temperature[:, :3], outlet + rng.normal(0.0, noise["temperature"], outlet.size)])
    return replace(f, temperature=temperature, **read)
