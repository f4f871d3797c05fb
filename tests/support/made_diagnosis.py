"""Diagnoses made of arrays alone, one per verdict, for tests of what people see of them."""

import numpy as np
from ddh_twin_py.estimation.fitting.calibration import FittedParameter
from ddh_twin_py.gap.diagnosis import Diagnosis, Weighed
from ddh_twin_py.gap.explain.detection import Detection
from ddh_twin_py.gap.findings import Lack, Shape, Trace
from ddh_twin_py.rig import load_rig

KINDS = ("explained", "ambiguous", "unknown", "no_gap", "insufficient")
SIGNALS = {  # unit, floor, how far off the twin is in floors, and what it hangs on
    "speed": ("rad/s", 0.08, 1.0, "none"),
    "current": ("A", 0.05, 1.6, "speed"),
    "voltage": ("V", 0.4, 1.1, "none"),
    "electrical_power": ("W", 4.0, 1.7, "speed"),
    "pressure_piston_side": ("Pa", 4e4, 4.5, "speed"),
    "pressure_rod_side": ("Pa", 4e4, 1.0, "none"),
    "rod_velocity": ("m/s", 5e-4, 2.2, "speed"),
    "rod_position": ("m", 1e-3, 1.9, "none"),
    "temperature/motor_winding": ("K", 0.3, 1.0, "none"),
    "temperature/pump_1_case": ("K", 0.2, 2.8, "warm"),
    "temperature/tank_oil": ("K", 0.15, 1.4, "warm"),
}
_NO_GAP = ("no_gap", "insufficient")
_GAIN = {"faint": 0.4, "moderate": 9.0, "clear": 40.0}
_DETECTABLE = [
    Detection("tank.cooling", "W/K", None, None, "temperature/tank_oil", {"faint": 0.1, "moderate": None, "clear": None}),
    Detection("pump_1.friction", "N*m", 0.25, 3.1, "current", _GAIN),
    Detection("load.mass", "kg", -2.0, 1.9, "pressure_piston_side", _GAIN, nominal=149.5),
    Detection("motor.cooling", "1", 28.3, 2.8, "temperature/motor_housing", _GAIN, nominal=1.0, beyond=True),
]


def made_diagnosis(kind="explained", seconds=600.0, interval=0.05, seed=7):
    """A diagnosis of that verdict on a made-up recording of ``seconds``."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, interval)
    speed = 52.0 * np.sign(np.sin(2.0 * np.pi * time / 20.0)) * (np.abs(np.sin(2.0 * np.pi * time / 20.0)) > 0.35)
    oil = 296.0 + 18.0 * (1.0 - np.exp(-time / 900.0))
    traces = {} if kind == "insufficient" else _traces(kind, time, speed, oil, rng)
    report = _report(kind, traces)
    return Diagnosis(
        report=report, sentence=_SENTENCE[kind],
        recordings={"commissioning": ["bags/new"] if kind != "insufficient" else [], "field": ["bags/field <1>"], "validation": []},
        traces=traces,
        axes={} if kind == "insufficient" else {
            "speed, rad/s": (time, speed), "oil temperature, K": (time[::20], oil[::20]),
            "rod position, m": (time, 0.2 + 0.1 * np.sin(time / 7)),
        },
        lacking=_LACKING.get(kind, []), alone=[] if kind in _NO_GAP else _ALONE, weighed=_weighed(kind),
        confusable=_CONFUSABLE if kind == "ambiguous" else {},
        parameters=[] if kind == "insufficient" else _PARAMETERS, shapes=_shapes() if kind == "unknown" else [], rig=load_rig(),
        assumptions=["Noise is white.", "The <sheet>'s tolerances are normal distributions."], seconds={"reading": 0.8, "fitting": 12.3},
        added={"explained": ("pump_1.leakage",), "ambiguous": ("pump_1.friction",)}.get(kind, ()),
        detectable=_DETECTABLE if kind == "no_gap" else [],
    )


def _traces(kind, time, speed, oil, rng):
    traces = {}
    for name, (unit, floor, off, cause) in SIGNALS.items():
        when, drive, warm = (time[::20], speed[::20], oil[::20]) if "/" in name else (time, speed, oil)
        if name == "rod_position":
            when, drive, warm = time[::200], speed[::200], oil[::200]
        level = {"K": 300.0, "Pa": 6e6, "m/s": 0.07, "m": 0.0}.get(unit, 10.0)
        measured = level + 0.02 * level * np.sin(when / 9.0) + 0.6 * floor * rng.normal(size=when.size)
        shape = {"speed": drive / 35.0, "warm": (warm - warm[0]) / max(np.ptp(warm), 1e-9) * 1.7, "none": np.zeros(when.size)}[cause]
        size = 0.0 if kind in _NO_GAP else np.sqrt(max(off**2 - 0.36, 0.0))
        lacking = floor * size * shape
        left = 1.0 if kind == "unknown" else 0.05
        noisy = 0.75 * floor * np.sqrt(2.0) * np.sin(when / 3.1)
        traces[name] = Trace(when, measured, measured - lacking + noisy, measured - left * lacking + noisy, unit, 0.6 * floor, floor)
    return traces


def _rms(values):
    return float(np.sqrt(np.mean(values**2)))


def _report(kind, traces):
    shrink = {
        name: {"unit": t.unit, "before": _rms(t.measured - t.before), "after": _rms(t.measured - t.after), "noise": t.floor}
        for name, t in traces.items()
    }
    gap = {"as_is": None, "before": None, "after": None, "closed_fraction": None}
    if shrink:
        before, after = (_rms(np.array([row[k] / row["noise"] for row in shrink.values()])) for k in ("before", "after"))
        closed = (before - after) / (before - 1.0) if before >= 1.2 else None
        gap = {"as_is": before * 1.3, "before": before, "after": after, "closed_fraction": closed}
    unknown = {"component": "cylinder", "domain": "mechanical", "size": 410.0, "unit": "N", "depends_on": ["speed, rad/s"]}
    test = {
        "description": "Run the uncoupled motor at 1000 rpm for ten minutes.", "between": ["pump_1.friction", "motor.bearing_friction"],
        "expected_separation": 7.5,
    }
    return {
        "verdict": kind, "gap": gap,
        "where": [
            {"component": row.component, "domain": row.domain, "phase": row.phase, "share": row.share, "missing": row.value,
             "unit": row.unit, "std": row.std, "share_std": 0.04}
            for row in _LACKING.get(kind, []) if not row.regime
        ],
        "why": [
            {"effect": e, "probability": p, "parameters": parameters} for e, p, parameters in _WHY.get(kind, [])
        ],
        "classes": [["pump_1.friction", "motor.bearing_friction"]] if kind == "ambiguous" else [],
        "hypotheses": [{"effects": list(w.effects), "probability": w.probability, "gap_after": w.gap_after} for w in _weighed(kind)]
                      or [{"effects": [], "probability": 0.3, "gap_after": None}],
        "shrink": shrink, "unknown": unknown if kind == "unknown" else None, "next_test": test if kind == "ambiguous" else None,
        "held_out": "none" if kind == "insufficient" else "field bag, blocks of 60 s: 60 to 120 s, 300 to 360 s",
        "checks": [] if kind == "insufficient" else [
            {"effects": [] if kind == "no_gap" else ["cylinder.seal_friction"], "check": check, "measured": measured, "limit": limit}
            for check, measured, limit in (("left_behind", 2.4 if kind == "unknown" else 1.2, 2.2), ("drifted", 0.5, 8.0),
                                           ("resized", -0.4, 25.0), ("strained", 1.01, 1.15))],
        "notes": {
            "insufficient": ["bags/field <1>: topic /ddh/hydraulics/telemetry: 12 s of motion, at least 60 s are needed"],
            "ambiguous": ["No temperature sensor on the motor: friction in bearings and in pump 1 heat different parts, which none sees."],
        }.get(kind, []),
    }


_SENTENCE = {
    "explained": "Pump 1 leaks 1.83 times as much as when it was new, almost surely: this closes 94 % of the gap.",
    "ambiguous": "Friction was added on the shaft, in pump 1 or in the motor's bearings; this record cannot tell which.",
    "unknown": "Something in the cylinder acts that no effect of the catalogue explains.",
    "no_gap": "The twin explains the record to its noise floor; nothing beyond it needs explaining.",
    "insufficient": "The record does not allow an answer: too little motion.",
}
_LACKING = {
    "explained": [
        Lack("pump_1", "hydraulic", "lifting", "", -7.2e-6, 3e-7, "m3/s", 0.55),
        Lack("pump_1", "hydraulic", "lowering", "", -6.1e-6, 4e-7, "m3/s", 0.25),
        Lack("pump_1", "thermal", "all", "", 38.0, 6.0, "W", 0.12),
        Lack("line_a", "hydraulic", "transient", "", 2.1e4, 1.5e4, "Pa", 0.05),
        Lack("cylinder", "mechanical", "holding", "", 44.0, 30.0, "N", 0.03),
        Lack("pump_1", "hydraulic", "lifting", "speed 40 to 80 rad/s", -7.9e-6, 5e-7, "m3/s", 0.31),
        Lack("pump_1", "hydraulic", "lifting", "oil temperature 296 to 303 K", -6.2e-6, 5e-7, "m3/s", 0.24),
    ],
    "ambiguous": [
        Lack("motor", "mechanical", "all", "", 0.41, 0.05, "N*m", 0.7),
        Lack("pump_1", "mechanical", "all", "", 0.33, 0.2, "N*m", 0.3),
    ],
    "unknown": [
        Lack("cylinder", "mechanical", "lifting", "", 410.0, 25.0, "N", 0.8),
        Lack("sensor", "measurement", "all", "", 0.4, 0.1, "K", 0.2),
    ],
}
_ALONE = [Lack("pump_1", "hydraulic", "all", "", -6.5e-6, 9e-7, "m3/s", 0.7), Lack("oil", "thermal", "all", "", 25.0, 20.0, "W", 0.3)]
_WHY = {
    "explained": [
        ("pump_1.leakage", 0.987, {"leakage_ratio": {"value": 1.83, "std": 0.04, "unit": "1", "nominal": 1.0}}),
        ("cylinder.cross_leakage", 0.009, {}), ("unknown", 0.002, {}),
    ],
    "ambiguous": [
        ("pump_1.friction", 0.52, {"torque": {"value": 0.4, "std": 0.05, "unit": "N*m", "nominal": 0.0}}),
        ("motor.bearing_friction", 0.44, {"torque": {"value": 0.41, "std": 0.05, "unit": "N*m", "nominal": 0.0}}),
        ("line_b.pressure_drop", 0.03, {}),
    ],
    "unknown": [("unknown", 0.91, {}), ("cylinder.seal_friction", 0.08, {})],
}
_CONFUSABLE = {
    "pump_1.friction": "Both brake the same shaft; they differ in which part grows warm, and neither motor nor pump case has a sensor.",
    "motor.bearing_friction": "Both brake the same shaft; only the motor's housing would tell.",
}
_PARAMETERS = [
    FittedParameter("pump_1.leakage", "m3/(s*Pa)", 1.0e-12, 1.5e-13, 1.12e-12, 4e-14, True),
    FittedParameter("motor.torque_constant", "N*m/A", 2.5, 0.05, 2.49, 0.01, True),
    FittedParameter("tank.emissivity", "1", 0.9, 0.05, 0.9, 0.05, False),
    FittedParameter("measurement.pressure_rod_side_offset", "Pa", 0.0, 5e4, 1.2e4, 4e3, True),
]


def _weighed(kind):
    gains = {"pressure_piston_side": 840.0, "rod_velocity": 61.0, "temperature/pump_1_case": 12.0, "speed": 0.3, "voltage": -5.1}
    left = {"pressure_piston_side": 1.05, "rod_velocity": 1.02, "temperature/pump_1_case": 1.31, "speed": 0.98, "voltage": 1.0}
    none = Weighed((), 0.8 if kind == "no_gap" else 1e-12, None, {}, {}, {})
    if kind == "explained":
        return [
            Weighed(("pump_1.leakage",), 0.985, 1.04, {"pump_1.leakage": (1.83, 0.04, "1", 1.0)}, gains, left),
            Weighed(("cylinder.cross_leakage", "sensor.pressure_rod_side_offset"), 0.009, 1.2, {
                "cylinder.cross_leakage": (2.2e-13, 3e-14, "m3/(s*Pa)", 0.0), "sensor.pressure_rod_side_offset": (-2e4, 9e3, "Pa", 0.0),
            }, {**gains, "temperature/pump_1_case": -20.0}, {**left, "temperature/pump_1_case": 2.6}),
            Weighed(("unknown",), 0.002, None, {}, {}, {}), none,
        ]
    if kind == "ambiguous":
        return [
            Weighed((e,), p, 1.1, {e: (0.4, 0.05, "N*m", 0.0)}, {"current": 210.0, "electrical_power": 80.0}, {"current": 1.02})
            for e, p in (("pump_1.friction", 0.52), ("motor.bearing_friction", 0.44))
        ] + [none]
    if kind == "unknown":
        return [
            Weighed(("unknown",), 0.91, 2.6, {}, {}, {}),
            Weighed(("cylinder.seal_friction",), 0.08, 2.3, {"cylinder.seal_friction": (900.0, 80.0, "N", 280.0)}, gains, left), none,
        ]
    return [none] if kind == "no_gap" else []


def _shapes():
    at = np.linspace(-55.0, 55.0, 23)
    return [Shape("speed, rad/s", at, 400.0 * np.tanh(at / 12.0), 30.0 + 0.4 * np.abs(at), "N")]
