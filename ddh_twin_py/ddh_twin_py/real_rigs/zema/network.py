"""Thermal-hydraulic network of the ZeMA rig: tank in two zones, working circuit, cooling circuit.

Oil (c = rho c_p per flow, W/K per L/min; Q_w through the pump, Q_c through the cooler, T_1 suction zone, T_3 return zone):

    C_1 dT_1/dt = c Q_c (T_4 - T_1) + c m (T_3 - T_1)
    C_3 dT_3/dt = eta P + c (Q_c + m) (T_1 - T_3) - U (T_3 - T_air)
    T_4 = T_3 - eps (T_3 - T_air)          T_2 = T_1 + f P / (c Q_w)

Working circuit (p before the valve, bar; mu over its value at 40 degC):

    Q = Q_0 - g p mu_40/mu(T) - q sqrt(p / 155 bar)                     flow through the valve: slip of the pump, its fault
    V(a -> b) = K (1/a - 1/b)                                           stored by the accumulator's gas at constant temperature
    rise = t_c + t_p + r K/Q (b/a - 1 - ln b/a)/(b - a)                 share of a second missing after the closing, a to relief b
    closing = t_c (by pressure), t_c + t_f (by flow);  opening = t_o    integrals over the second of switching

K = p_0 V_0 of the gas: a lower pre-charge stores less at every pressure above it. Inputs are the motor's power, the flows and the
pressures of the loads; nothing but those and the first temperatures is taken from the recording.
"""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.physics.compiled import kernel
from ddh_twin_py.real_rigs.zema.features import Features
from ddh_twin_py.real_rigs.zema.recordings import SECONDS

HEAT = 27.6
"""W/K per L/min: 0.87 kg/L at 1.9 kJ/(kg K)."""
AT_LEAK = 155.0
"""bar, at which the fault's leakage is told."""
_WALTHER_B = 3.45  # mineral oil of viscosity index 100
_AT = 46.0  # cSt at 40 degC, HLP 46
_STEPS = 6  # of a cycle


def viscosity_ratio(temperature: np.ndarray) -> np.ndarray:
    """Kinematic viscosity over that at 40 degC, by Walther (ASTM D341) for HLP 46; degC."""
    a = math.log10(math.log10(_AT + 0.7)) + _WALTHER_B * math.log10(313.15)
    return (10.0 ** (10.0 ** (a - _WALTHER_B * np.log10(273.15 + np.asarray(temperature)))) - 0.7) / _AT


@kernel
def _temperatures(start_1, start_3, power, pump, cooler, effectiveness, air, c_1, c_3, eta, f, mixing, wall):
    """Means of each cycle of T_1 to T_4, degC, (n, 4), from the zones' temperatures at the start; ``effectiveness`` (n,)."""
    n = power.size
    out = np.empty((n, 4))
    t_1, t_3 = start_1, start_3
    step = SECONDS / _STEPS
    for i in range(n):
        sum_1, sum_3 = 0.0, 0.0
        conductance = HEAT * mixing
        for _ in range(_STEPS):
            t_4 = t_3 - effectiveness[i] * (t_3 - air)
            d_1 = HEAT * cooler[i] * (t_4 - t_1) + conductance * (t_3 - t_1)
            d_3 = eta * power[i] + (HEAT * cooler[i] + conductance) * (t_1 - t_3) - wall * (t_3 - air)
            t_1 += step * d_1 / c_1
            t_3 += step * d_3 / c_3
            sum_1 += t_1
            sum_3 += t_3
        one, three = sum_1 / _STEPS, sum_3 / _STEPS
        out[i, 0] = one
        out[i, 1] = one + f * power[i] / (HEAT * pump[i])
        out[i, 2] = three
        out[i, 3] = three - effectiveness[i] * (three - air)
    return out


def temperatures(f: Features, p: np.void, effectiveness: np.ndarray | None = None) -> np.ndarray:
    """Free run of the oil's temperatures, degC, means of each cycle of T_1 to T_4, (n, 4).

    Args:
        p: parameter record. effectiveness: of the cooler by cycle, (n,); None takes the record's.
    """
    n = f.power.size
    given = np.full(n, float(p["effectiveness"])) if effectiveness is None else np.asarray(effectiveness, dtype=np.float64)
    heat = 1e3 * float(p["heat_capacity"])
    pump = f.pump
    return _temperatures(float(f.temperature[0, 0]), float(f.temperature[0, 2]), f.power, np.maximum(pump, 1.0), f.cooling, given,
                         float(p["air"]), 0.4 * heat, 0.6 * heat, float(p["heat_share"]), float(p["pump_heat_share"]),
                         float(p["mixing"]), float(p["wall"]))


def slip(pressure: np.ndarray, oil: np.ndarray, p: np.void) -> np.ndarray:
    """Slip of the pump, L/min, at pressures (n, m) bar and oil temperatures (n,) degC."""
    return float(p["slip"]) * pressure / viscosity_ratio(oil)[:, None]


def flows(f: Features, oil: np.ndarray, p: np.void) -> np.ndarray:
    """Flow through the valve at each load, L/min, (n, 5)."""
    return float(p["pump_flow"]) - slip(f.pressure, oil, p) - float(p["leakage"]) * np.sqrt(np.maximum(f.pressure, 0.0) / AT_LEAK)


def stored(f: Features) -> np.ndarray:
    """What an accumulator of K = 1 L bar takes up at each step, L, (n, 4)."""
    return 1.0 / f.pressure[:, :-1] - 1.0 / f.pressure[:, 1:]


def rise(f: Features) -> np.ndarray:
    """Share of a second that an accumulator of K = 1 L bar makes the pressure late after the closing, (n,)."""
    flow, start = f.before
    ratio = np.maximum(f.relief / np.maximum(start, 1.0), 1.0 + 1e-6)
    return 60.0 / np.maximum(flow, 0.1) * (ratio - 1.0 - np.log(ratio)) / np.maximum(f.relief - start, 1e-3)


def predict(f: Features, p: np.void) -> dict[str, np.ndarray]:
    """Every signal as the network says it: temperatures (n,), flow (n, 5), stored (n, 4), closing (n, 2), opening and rise (n,)."""
    oil = temperatures(f, p)
    gas, closing = float(p["gas"]), float(p["closing"])
    n = f.power.size
    out = {f"temperature/TS{i + 1}": oil[:, i] + float(p[f"TS{i + 1}_offset"]) for i in range(4)}
    out["flow"] = float(p["FS1_gain"]) * flows(f, 0.5 * (oil[:, 0] + oil[:, 1]), p)
    out["stored"] = float(p["FS1_gain"]) * gas * stored(f)
    out["closing"] = closing + np.array([0.0, float(p["flow_late"])]) * np.ones((n, 1))
    out["opening"] = np.full(n, float(p["opening"]))
    out["rise"] = closing + float(p["rise_late"]) + float(p["rise_ratio"]) * gas * rise(f)
    return out
