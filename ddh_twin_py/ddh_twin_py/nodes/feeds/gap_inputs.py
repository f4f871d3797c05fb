"""What the models publish, from their messages to the arrays that the gap watch takes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ddh_msgs.msg import ResidualArray, TemperatureEstimateArray
from ddh_twin_py.gap.watch.watch import HYDRAULIC
from ddh_twin_py.nodes.messages.conversion import FREE_RUN
from ddh_twin_py.nodes.messages.named import of_source, ordered
from ddh_twin_py.nodes.messages.wire import BulkParser
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.telemetry.clocks.clock import same_unit
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX
from ddh_twin_py.twin.lagged_readings import LaggedReadings
from ddh_twin_py.twin.temperature_sensors import SENSORS, all_sensed

RESIDUAL_TOPIC = "hydraulics/residuals"
ESTIMATE_TOPIC = "temperature/estimates"
READING_TOPIC = "temperature/residuals"
_LONGEST_STEP = 1_000_000_000  # ns between two estimates of one run
_KEPT = 120_000_000_000  # ns for which a free run's temperature waits for a reading
_VELOCITY = "rod_velocity"


class Forward:
    """Leaves out what comes again by a clock that was put back a little, so that what was learned is kept; `put_back` counts these times.

    A step back by more is let through.
    """

    def __init__(self) -> None:
        self._newest: int | None = None
        self._again = False
        self.put_back = 0

    def used(self, stamp_ns: np.ndarray) -> np.ndarray:
        """Which of n samples are beyond all before them, or of another time, bool (n,); ``stamp_ns`` as they came, int64 (n,)."""
        used = np.ones(stamp_ns.size, bool)
        for i, stamp in enumerate(stamp_ns.tolist()):
            again = self._newest is not None and same_unit((stamp - self._newest) * 1e-9)
            self.put_back += again and not self._again
            self._again, used[i] = again, not again
            if not again:
                self._newest = stamp
        return used


class FreeRunResiduals:
    """Residuals of the free run out of `hydraulics/residuals`, which holds those of the soft sensor too."""

    def __init__(self) -> None:
        self._parser = BulkParser(ResidualArray)

    @property
    def parsers(self) -> dict[str, BulkParser]:
        """What parses each topic, and knows what was left out."""
        return {RESIDUAL_TOPIC: self._parser}

    def parse(self, messages: Sequence[bytes]) -> list[tuple[np.ndarray, ...]]:
        """Runs of stamps int64 (n,) in ns, measured, predicted (n, S) and rod velocity in m/s (n,), NaN for a signal that is not named."""
        runs = []
        for example, stamps, values in self._parser.parse(of_source(messages, FREE_RUN)):
            names = [residual.signal for residual in example.residuals]
            measured, predicted = values["residuals.measured"], values["residuals.predicted"]
            signals = [ordered(names, [name for name, _, _ in HYDRAULIC], block) for block in (measured, predicted)]
            velocity, expected = (ordered(names, [_VELOCITY], block)[:, 0] for block in (measured, predicted))
            runs.append((stamps, *signals, np.where(np.isfinite(velocity), velocity, expected)))
        return runs


class FreeRunTemperatures:
    """Readings out of `temperature/residuals`, those that the filter refused too, beside what the free run lets the sensors read.

    The free run's temperatures come with the estimates; here the sensors meet them (`sensed`), they pass the sensors' lags, s, and wait
    for the readings of their time.
    """

    def __init__(self, lag: np.ndarray, top_share: float) -> None:
        self._estimates, self._readings = BulkParser(TemperatureEstimateArray), BulkParser(ResidualArray)
        self._lagging, self._top_share = LaggedReadings(lag), top_share
        self._last: int | None = None  # ns, stamp of the free run that was taken last
        self._expected: dict[int, np.ndarray] = {}  # degC (S,) by stamp in ns

    @property
    def parsers(self) -> dict[str, BulkParser]:
        """What parses each topic, and knows what was left out."""
        return {ESTIMATE_TOPIC: self._estimates, READING_TOPIC: self._readings}

    def take_estimates(self, messages: Sequence[bytes]) -> int | None:
        """Keep the free run's temperatures; the newest stamp in ns, None without a message."""
        newest = None
        for example, stamps, values in self._estimates.parse(messages):
            names = [estimate.location for estimate in example.estimates]
            predicted = all_sensed(ordered(names, NODES, values["estimates.predicted"]), self._top_share)
            steps = np.diff(stamps, prepend=stamps[0] - 1 if self._last is None else self._last)
            unusable = ~np.isfinite(predicted).all(axis=1)
            broken = (steps <= 0) | (steps > _LONGEST_STEP) | unusable
            cuts = [0, *np.flatnonzero(broken).tolist(), *(np.flatnonzero(unusable) + 1).tolist(), stamps.size]
            for first, stop in pairwise(sorted(set(cuts))):
                self._pass_lag(stamps[first:stop], predicted[first:stop], bool(broken[first]))
            newest = int(stamps[-1])
        if newest is not None:
            self._expected = {stamp: row for stamp, row in self._expected.items() if abs(newest - stamp) < _KEPT}
        return newest

    def _pass_lag(self, stamps: np.ndarray, predicted: np.ndarray, anew: bool) -> None:
        if not np.isfinite(predicted).all():
            self._last = None
            return
        if anew or self._last is None:
            self._last = int(stamps[0]) - (int(stamps[-1]) - int(stamps[0])) // max(stamps.size - 1, 1)
            self._lagging.begin_anew()
        seen = self._lagging.follow(predicted, (int(stamps[-1]) - self._last) * 1e-9 / stamps.size)
        self._expected.update(zip(stamps.tolist(), seen, strict=True))
        self._last = int(stamps[-1])

    def parse(self, messages: Sequence[bytes]) -> list[tuple[np.ndarray, ...]]:
        """Runs of stamps int64 (n,) in ns, measured and expected in degC (n, S); NaN where there is no reading, or no free run."""
        runs = []
        for example, stamps, values in self._readings.parse(messages):
            names = [residual.signal for residual in example.residuals]
            measured = ordered(names, [TEMPERATURE_PREFIX + sensor for sensor in SENSORS], values["residuals.measured"])
            unknown = np.full(len(SENSORS), np.nan)
            runs.append((stamps, measured, np.array([self._expected.get(stamp, unknown) for stamp in stamps.tolist()])))
        return runs
