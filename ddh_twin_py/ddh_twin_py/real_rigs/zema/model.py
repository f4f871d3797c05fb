"""Consecutive cycles of the ZeMA rig as the gap engine sees them (`run.Run`)."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Signal
from ddh_twin_py.real_rigs.run import Run
from ddh_twin_py.real_rigs.signals import signal
from ddh_twin_py.real_rigs.zema import network
from ddh_twin_py.real_rigs.zema.features import CLOSING, LOADS, OPENING, STEPS, Features, features
from ddh_twin_py.real_rigs.zema.recordings import SECONDS, Record

NOISE = {"flow": 0.01, "stored": 5e-4, "closing": 0.005, "opening": 0.003, "rise": 0.005}
"""L/min, L, s, s, 1: what one cycle's number scatters, and what the network's law is off by."""
TEMPERATURE_NOISE = 0.3
"""K: the air warms and cools by more than the sensors' noise, and the network takes it as constant."""
_UNITS = {"flow": "L/min", "stored": "L", "closing": "s", "opening": "s", "rise": "1"}
_PLACE = {"flow": tuple(load.start for load in LOADS), "stored": STEPS, "closing": (CLOSING, CLOSING + 1), "opening": (OPENING,),
          "rise": (CLOSING,)}  # second of the cycle at which each number stands


class Cycles(Run):
    """Cycles of a record from ``first`` on; the last ``held`` of them take no part in finding or fitting."""

    def __init__(self, record: Record, which: slice, held: int = 0) -> None:
        first, last = which.start, which.stop
        self.name = f"cycles {first} to {last - 1}"
        self.features: Features = features({name: values[which] for name, values in record.signals.items()})
        self.signals: dict[str, Signal] = {}
        until = SECONDS * (last - first - held) - 0.5 if held else np.inf
        for name, values in measured(self.features).items():
            many = values.reshape(values.shape[0], -1)
            if not np.isfinite(many).any():
                continue  # locked throughout
            place = np.array(_PLACE.get(name, (SECONDS // 2,)))
            time = (SECONDS * np.arange(many.shape[0])[:, None] + place).ravel().astype(np.float64)
            kind = np.tile(np.arange(place.size), many.shape[0])
            noise, unit = (NOISE[name], _UNITS[name]) if name in NOISE else (TEMPERATURE_NOISE, "degC")
            self.signals[name] = signal(time, many.ravel(), noise, unit, kind=kind, used_until=until, held_from=until)

    def predict(self, record: np.ndarray) -> dict[str, np.ndarray]:
        """Every signal by the network, (n,)."""
        return {name: values.ravel() for name, values in network.predict(self.features, record[0]).items()}

    def variables(self, record: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """The oil's temperature, read."""
        n = self.features.power.size
        return {"oil temperature, degC": (SECONDS * (np.arange(n) + 0.5), self.features.temperature[:, :2].mean(axis=1))}


def measured(f: Features) -> dict[str, np.ndarray]:
    """What the network predicts, as it was read; shapes as in `network.predict`, NaN where a load was locked."""
    flow = np.where(f.working, f.flow, np.nan)
    return {**{f"temperature/TS{i + 1}": f.temperature[:, i] for i in range(4)}, "flow": flow, "stored": f.stored, "closing": f.closing,
            "opening": f.opening, "rise": f.rise}
