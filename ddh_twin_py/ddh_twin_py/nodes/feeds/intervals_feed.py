"""From ticks to the intervals that the models take, in batches."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fusion.inputs import Reading
from ddh_twin_py.physics.soft_sensor import MEASURED_DTYPE
from ddh_twin_py.telemetry.clocks.clock import same_unit
from ddh_twin_py.telemetry.signals import (
    DRIVE_FIELDS,
    DRIVE_TOPIC,
    HYDRAULIC_FIELDS,
    HYDRAULIC_TOPIC,
    TEMPERATURE_PREFIX,
)
from ddh_twin_py.telemetry.ticks import Tick
from ddh_twin_py.twin.intervals import command_size, new_carry, reduce_intervals

AMBIENT = "ambient"


@dataclass(frozen=True)
class Batch:
    """n intervals that follow each other.

    `first`: they do not follow those before. `put_back`: a clock was put back a little, and the model goes on as warm as it is; where
    it was not, `first` is where the model starts anew. `end_ns` int64[n]; `measured` `MEASURED_DTYPE` (n,);
    `command` rad/s, (`command_size` (n),); `air` K as read in each interval, (n,), NaN where it
    was not; `readings` of the temperature sensors, index within the batch.
    """

    first: bool
    put_back: bool
    end_ns: np.ndarray
    measured: np.ndarray
    command: np.ndarray
    air: np.ndarray
    readings: list[Reading]

    def __len__(self) -> int:
        return self.end_ns.size

    def part(self, start: int, stop: int) -> Batch:
        """The intervals start..stop."""
        rows, command = slice(start, stop), self.command[command_size(start) - 1 : command_size(stop)]
        readings = [replace(r, index=r.index - start) for r in self.readings if start <= r.index < stop]
        first, put_back = self.first and start == 0, self.put_back and start == 0
        return Batch(first, put_back, self.end_ns[rows], self.measured[rows], command, self.air[rows], readings)


class IntervalsFeed:
    """Reduces ticks to intervals.

    Holds back the newest tick, whose samples tell the command at the last edge, and where a model
    starts anew the ticks of `start` seconds, whose readings tell where.
    """

    def __init__(self, interval: float, start: float) -> None:
        self._interval = interval
        self._start_ticks = max(1, round(start / interval) + 1)
        self._waiting: list[Tick] = []
        self._one_unit = True  # whether what was told before the newest tick is of the same unit
        self._begin(None)

    def _begin(self, epoch_ns: int | None, put_back: bool = False) -> None:
        self._carry = new_carry()
        self._epoch_ns = epoch_ns
        self._first, self._put_back = True, put_back

    @property
    def waiting(self) -> list[Tick]:
        """Ticks that are held back."""
        return self._waiting

    def begin_anew(self) -> None:
        """The model starts anew with what comes from now on, as after a restart of the ticks; what waits is kept."""
        self._begin(self._waiting[0].start_ns if self._waiting else None)
        self._one_unit = False

    def add(self, ticks: list[Tick], flush: bool = False) -> Iterator[Batch]:
        """Batches that can be computed now; `flush`: hold nothing back."""
        for tick in ticks:
            if self._epoch_ns is None:
                self._begin(tick.start_ns)
            elif tick.restart:
                if self._waiting:
                    yield self._reduce(self._waiting, None)
                    self._waiting = []
                self._begin(tick.start_ns, self._one_unit and self._started and same_unit(tick.gap))
                self._one_unit = True
            self._waiting.append(tick)
        held = 0 if flush else 1
        enough = len(self._waiting) > (held if self._started or flush else self._start_ticks)
        if enough:
            ready = self._waiting[: len(self._waiting) - held]
            following = self._waiting[-1] if held else None
            self._waiting = self._waiting[len(ready) :]
            self._one_unit = True
            yield self._reduce(ready, following)

    @property
    def _started(self) -> bool:
        """Whether there is a model that goes on with what comes."""
        return not self._first or self._put_back

    def _reduce(self, ticks: list[Tick], following: Tick | None) -> Batch:
        n = len(ticks)
        end_ns = np.array([tick.end_ns for tick in ticks], np.int64)
        measured, command = np.zeros(n, MEASURED_DTYPE), np.empty(command_size(n))
        beyond = [*ticks, following] if following is not None else ticks
        reduce_intervals(
            (ticks[0].start_ns - self._epoch_ns) * 1e-9, self._interval,
            *self._joined(beyond, n, DRIVE_TOPIC, len(DRIVE_FIELDS)),
            *self._joined(beyond, n, HYDRAULIC_TOPIC, len(HYDRAULIC_FIELDS)),
            self._carry, measured, command,
        )  # fmt: skip
        air, readings = np.full(n, np.nan), []
        for i, tick in enumerate(ticks):
            for reading in readings_of(tick, i):
                readings.append(reading)
                if reading.sensor == AMBIENT:
                    air[i] = reading.temperature
        first, put_back = self._first, self._put_back
        self._first = self._put_back = False
        return Batch(first, put_back, end_ns, measured, command, air, readings)

    def _joined(self, ticks: list[Tick], n: int, topic: str, width: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times in s, samples (m, width) of all ticks, and for the first n where each one ends."""
        parts = [tick.samples[topic] for tick in ticks if topic in tick.samples]
        if not parts:
            return np.empty(0), np.empty((0, width)), np.zeros(n, np.int64)
        stamps = np.concatenate([part.stamp for part in parts])
        values = np.ascontiguousarray(np.concatenate([part.values for part in parts]))
        stop = np.cumsum([len(part) for part in parts[:n]])
        return (stamps - self._epoch_ns) * 1e-9, values, stop


def readings_of(tick: Tick, index: int) -> Iterator[Reading]:
    """Temperature readings of a tick that are believed, `index` being its place in the batch."""
    for topic, samples in tick.samples.items():
        if topic.startswith(TEMPERATURE_PREFIX) and len(samples):
            sensor = topic.removeprefix(TEMPERATURE_PREFIX)
            for value in samples.values[:, 0]:
                if np.isfinite(value):
                    yield Reading(index, sensor, float(value))
