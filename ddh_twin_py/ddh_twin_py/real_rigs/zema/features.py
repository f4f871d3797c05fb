"""What one cycle of the ZeMA rig says of its hydraulics: steady loads, switching times of the valve, oil stored at each step of pressure.

A sample is the mean over its second. What happens within a second (a valve that closes in a tenth of it) is therefore not seen, but its
integral is: the pressure behind the valve in the second of closing, over the pressure before, is the time for which it was open.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LOADS = (slice(13, 19), slice(22, 29), slice(32, 39), slice(42, 49), slice(53, 60))
"""Seconds of a cycle in which the load stands still; from second 0 to 9 the valve is closed, the pump works against the relief valve."""
STEPS = (19, 29, 39, 49)
"""Seconds in which the load changes from one of `LOADS` to the next."""
CLOSED = slice(3, 9)
"""Seconds in which the pump works against the relief valve, settled."""
CLOSING, OPENING = 0, 9
"""Seconds in which the valve switches."""
LOCKED = 0.95
"""Share of the relief valve's pressure above which a load counts as locked: oil goes over the relief valve, the flow says nothing of
the pump."""
_OPENED = 0.97  # of the pressure of the load, above which the second after the opening says nothing more of it


@dataclass(frozen=True)
class Features:
    """Numbers of each cycle, (n,) unless said otherwise.

    Attributes:
        flow, pressure, behind: at each of `LOADS`: L/min through the valve, bar before and behind it, (n, 5).
        working: whether the load was not `LOCKED`, (n, 5); what a locked load leaves unknown is NaN in the numbers below.
        relief: bar, against the relief valve. power: W of the motor, mean of the cycle. through: L/min through the load, mean of the cycle.
        cooling: L/min through the cooler. temperature: degC, TS1 to TS4, means of the cycle, (n, 4).
        closing: s, how long the valve still let oil through, by pressure and by flow, (n, 2). opening: s, how late it let oil through.
        rise: share of a second by which the pressure before the valve came late to the relief valve's.
        stored: L taken up (given back below 0) at each of `STEPS`, (n, 4).
    """

    flow: np.ndarray
    pressure: np.ndarray
    behind: np.ndarray
    working: np.ndarray
    relief: np.ndarray
    power: np.ndarray
    through: np.ndarray
    cooling: np.ndarray
    temperature: np.ndarray
    closing: np.ndarray
    opening: np.ndarray
    rise: np.ndarray
    stored: np.ndarray

    @property
    def before(self) -> tuple[np.ndarray, np.ndarray]:
        """Flow L/min and pressure bar before the valve at the end of the cycle before, (n,) each; of the first cycle, its own end."""
        return _before(self.flow[:, -1]), _before(self.pressure[:, -1])

    @property
    def pump(self) -> np.ndarray:
        """Flow through the pump, L/min, (n,): mean of the loads that are not locked; of none, the median of all cycles."""
        count = self.working.sum(axis=1)
        total = np.where(self.working, self.flow, 0.0).sum(axis=1)
        whole = np.where(count > 0, total / np.maximum(count, 1), np.nan)
        return np.where(np.isfinite(whole), whole, np.nanmedian(whole))


def _before(values: np.ndarray) -> np.ndarray:
    return np.concatenate([values[:1], values[:-1]])


def features(signals: dict[str, np.ndarray]) -> Features:
    """Features of consecutive cycles, signals (n, 60) each by name."""
    def at_loads(name: str) -> np.ndarray:
        return np.stack([signals[name][:, load].mean(axis=1) for load in LOADS], axis=1)

    flow, pressure, behind = at_loads("FS1"), at_loads("PS1"), at_loads("PS2")
    relief = signals["PS1"][:, CLOSED].mean(axis=1)
    working = pressure < LOCKED * relief[:, None]
    begun = _before(working[:, -1])
    closing = np.stack([(signals[name][:, CLOSING] + signals[name][:, CLOSING + 1]) / np.maximum(_before(own), 1e-3)
                        for name, own in (("PS2", behind[:, -1]), ("FS1", flow[:, -1]))], axis=1)
    late = 1.0 - signals["PS2"][:, OPENING : OPENING + 2] / np.maximum(behind[:, :1], 1e-3)
    closing = np.where(begun[:, None], closing, np.nan)
    opening = late[:, 0] + np.where(late[:, 1] > 1.0 - _OPENED, late[:, 1], 0.0)
    start = _before(pressure[:, -1])
    missing = 2.0 * relief - signals["PS1"][:, CLOSING] - signals["PS1"][:, CLOSING + 1]
    rise = np.where(begun, missing / np.maximum(relief - start, 1e-3), np.nan)
    stored = np.stack([_stored(signals["FS1"], step, flow[:, i], flow[:, i + 1]) for i, step in enumerate(STEPS)], axis=1)
    stored = np.where(working[:, :-1] & working[:, 1:], stored, np.nan)
    opening = np.where(working[:, 0], opening, np.nan)
    temperature = np.stack([signals[f"TS{i}"].mean(axis=1) for i in (1, 2, 3, 4)], axis=1)
    power, through, cooling = (signals[name].mean(axis=1) for name in ("EPS1", "FS1", "FS2"))
    return Features(flow, pressure, behind, working, relief, power, through, cooling, temperature, closing, opening, rise, stored)


def _stored(flow: np.ndarray, step: int, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """L that did not come through in the second of a step and the next, the step in its middle, (n,)."""
    return (0.5 * before + 1.5 * after - flow[:, step] - flow[:, step + 1]) / 60.0
