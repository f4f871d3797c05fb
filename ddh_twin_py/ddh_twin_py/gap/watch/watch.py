"""Watches free run against telemetry, all signals: running tests of the hydraulic signals and of the temperatures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.gap.watch.normal_level import NormalLevel
from ddh_twin_py.gap.watch.pointing import pointed_component
from ddh_twin_py.gap.watch.running_test import RunningTest, Settings, SignalStatus
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.twin.hydraulic_model import RESIDUAL_SIGNALS

HYDRAULIC = tuple((name, key, unit) for name, key, unit in RESIDUAL_SIGNALS if name not in ("torque", "rod_position"))
"""Signals of the free run that are watched: name, key of the noise in the sheet, unit. Torque is current times a constant;
the rod's position is put back at each standstill."""
TEMPERATURES = tuple(TEMPERATURE_PREFIX + sensor for sensor in SENSORS)
UNITS = {name: unit for name, _, unit in HYDRAULIC} | dict.fromkeys(TEMPERATURES, "K")
"""Unit of each watched signal's residual."""
MOVING = 0.002
"""m/s of rod velocity above which the rig lifts or lowers."""
BLUNT = 10.0
"""Multiple of a sample's noise from which a learned floor hides what a fitted twin would show."""
_PHASES = 3  # holding, lifting, lowering
PHASES = {name: _PHASES for name, _, _ in HYDRAULIC} | dict.fromkeys(TEMPERATURES, 1)
"""How many phases the normal level of each watched signal has."""
_REMEMBERED = 120_000_000_000  # ns in which temperatures may come after the hydraulics of the same time


@dataclass(frozen=True)
class Scaled:
    """Residuals in multiples of the noise floor, each (n, S): measured, expected (free run and normal level), and their difference."""

    stamp_ns: np.ndarray
    measured: np.ndarray
    expected: np.ndarray
    residual: np.ndarray
    noise: np.ndarray


class GapWatch:
    """Running tests of all signals on the stamps of the telemetry.

    The phase of a hydraulic residual is holding, lifting or lowering; a temperature's normal level is one for all
    phases. Bins in which the rod never moves are not tested, and teach nothing.
    """

    def __init__(self, rig: Rig, settings: Settings, known: Mapping[str, NormalLevel] | None = None) -> None:
        self.rig, self.settings = rig, settings
        noise = [rig.sensors[key].noise if key in rig.sensors else np.nan for _, key, _ in HYDRAULIC]
        kelvin = rig.sensors["temperature"].noise if "temperature" in rig.sensors else np.nan
        among = len(HYDRAULIC) + len(TEMPERATURES)
        self.hydraulics = RunningTest([name for name, _, _ in HYDRAULIC], noise, _PHASES, settings, among, known=known)
        self.temperatures = RunningTest(TEMPERATURES, [kelvin] * len(TEMPERATURES), 1, settings, among, floor_with_level=True, known=known)
        self._forget_movement()

    def _forget_movement(self) -> None:
        self._moved_at, self._moved = np.empty(0, np.int64), np.empty(0, bool)

    def take_hydraulics(self, stamp_ns: np.ndarray, measured: np.ndarray, predicted: np.ndarray,
                        velocity: np.ndarray) -> tuple[Scaled, int]:
        """n intervals of the hydraulic signals in the order of `HYDRAULIC`; what to show, and how many bins were finished.

        Args:
            stamp_ns: end of each interval, int64 (n,). measured, predicted: in SI, (n, S). velocity: of the rod, m/s, NaN unknown, (n,).
        """
        phase = np.where(velocity > MOVING, 1, np.where(velocity < -MOVING, 2, 0))
        resets = self.hydraulics.resets
        finished = self.hydraulics.advance(stamp_ns, measured - predicted, phase, phase > 0)
        if self.hydraulics.resets != resets:
            self.temperatures.reset()
            self._forget_movement()
        self.temperatures.worked_at(stamp_ns[phase > 0])
        self._moved_at = np.concatenate((self._moved_at, stamp_ns))
        self._moved = np.concatenate((self._moved, phase > 0))
        recent = self._moved_at > self._moved_at[-1] - _REMEMBERED if self._moved_at.size else np.empty(0, bool)
        self._moved_at, self._moved = self._moved_at[recent], self._moved[recent]
        return _scaled(self.hydraulics, stamp_ns, measured, predicted, phase), finished

    def take_temperatures(self, stamp_ns: np.ndarray, measured: np.ndarray, predicted: np.ndarray) -> tuple[Scaled, int]:
        """n readings of the temperatures in the order of `TEMPERATURES`, both in one unit, NaN where nothing was read; (n, S).

        A reading that comes after a newer one, or before the hydraulics of its time, is left out.
        """
        newest = self.temperatures.newest_ns
        before = np.maximum.accumulate(np.concatenate(([-1 if newest is None else newest], stamp_ns[:-1])))
        used = (stamp_ns > before) & (stamp_ns <= (self._moved_at[-1] if self._moved_at.size else -1))
        stamp_ns, measured, predicted = stamp_ns[used], measured[used], predicted[used]
        phase = np.zeros(stamp_ns.size, int)
        works = np.isin(self.temperatures.bins(stamp_ns), self.temperatures.bins(self._moved_at[self._moved]))
        finished = self.temperatures.advance(stamp_ns, measured - predicted, phase, works)
        return _scaled(self.temperatures, stamp_ns, measured, predicted, phase), finished

    def end_learning(self) -> None:
        """Take what was learned so far as normal; see `RunningTest.end_learning`."""
        self.hydraulics.end_learning()
        self.temperatures.end_learning()

    @property
    def levels(self) -> dict[str, NormalLevel]:
        """Normal levels that are complete, by signal."""
        return {**self.hydraulics.levels, **self.temperatures.levels}

    @property
    def resets(self) -> int:
        """How often the clock jumped back."""
        return self.hydraulics.resets

    @property
    def newest_end_ns(self) -> int:
        """Stamp of the end of the newest finished bin, ns."""
        return max(self.hydraulics.newest_end_ns, self.temperatures.newest_end_ns)

    def status(self) -> list[SignalStatus]:
        """How each signal stands: hydraulics, then temperatures."""
        return [*self.hydraulics.status(), *self.temperatures.status()]

    def blunt(self) -> dict[str, float]:
        """Signals whose learned floor is `BLUNT` times a sample's noise or more, the worst first, with that multiple.

        So far off is a twin of parameters that are not the rig's: its gaps are small beside what it leaves anyway.
        """
        noise = {name: float(value) for test in (self.hydraulics, self.temperatures)
                 for name, value in zip(test.signals, test.noise, strict=True)}  # fmt: skip
        times = {name: level.floor / noise[name] for name, level in self.levels.items() if noise[name] > 0.0}
        return dict(sorted(((name, ratio) for name, ratio in times.items() if ratio >= BLUNT), key=lambda row: -row[1]))

    def component(self, statuses: list[SignalStatus]) -> tuple[str, str]:
        """What the open signals point to, and why; see `pointed_component`."""
        return pointed_component(statuses, self.rig)


def _scaled(test: RunningTest, stamp_ns: np.ndarray, measured: np.ndarray, predicted: np.ndarray, phase: np.ndarray) -> Scaled:
    floor = test.floors()
    expected = predicted + test.expected(phase)
    return Scaled(stamp_ns, measured / floor, expected / floor, (measured - expected) / floor,
                  np.broadcast_to(test.noise / floor, measured.shape))  # fmt: skip
