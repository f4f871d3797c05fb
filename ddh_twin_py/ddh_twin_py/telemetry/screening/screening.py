"""Judge every sample: finite, in range, below the sensor's full scale, in a likely unit, in order, alive.

One implementation for whole recordings and for the few samples that a live node gets at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry import screening_kernel as kernel
from ddh_twin_py.telemetry.causes import CAUSES, Cause
from ddh_twin_py.telemetry.clocks.clock import clock_segments, sorted_order
from ddh_twin_py.telemetry.clocks.set_ahead import clock_set_ahead
from ddh_twin_py.telemetry.recording import Finding, Recording, Stream
from ddh_twin_py.telemetry.screening.all_zero import all_zero
from ddh_twin_py.telemetry.screening.screening_report import Counted, findings_of, in_another_unit
from ddh_twin_py.telemetry.screening.sensor_end import sensor_end
from ddh_twin_py.telemetry.screening.told_variance import odd_variances
from ddh_twin_py.telemetry.screening.too_seldom import too_seldom
from ddh_twin_py.telemetry.signals import HYDRAULIC_TOPIC, KELVIN, TEMPERATURE_PREFIX, TENTHS, ZERO_CELSIUS, Signal, UnitMistake, signals_of
from ddh_twin_py.telemetry.spans import apart, missing_ends
from ddh_twin_py.telemetry.ticks import REORDER_WINDOW, to_ns
from ddh_twin_py.telemetry.units.alike_units import alike_units, first_readings, likely_units
from ddh_twin_py.telemetry.units.temperature_units import odd_temperatures
from ddh_twin_py.telemetry.units.unit_rules import judge, rules_of
from ddh_twin_py.telemetry.units.unit_scales import UnitScales
from ddh_twin_py.telemetry.units.unit_suspicion import UnitSuspicion

_WHOLE = 1e-3  # by which a whole number may be off in single precision
_STUCK = CAUSES.index(Cause.STUCK)
_MOST_STOPS = 16  # that are kept for a listener
_THOUSANDFOLD, _REACHED = 1e3, 0.01  # factor of a mistake of unit from which values out of range must reach, in the right unit, this share
# of the largest that is allowed: 120 N*m out of range are no 0.12 N*m
_NOT_IN_RUNS = (
    Cause.NOT_A_NUMBER | Cause.INFINITE | Cause.OUT_OF_RANGE | Cause.SATURATED | Cause.REPEATED | Cause.OUT_OF_ORDER
)  # what the kernel does not look at when it counts repetitions


@dataclass(frozen=True)
class Screened:
    """Samples after screening, in the order given.

    `stamp` int64[n] ns; `values` float64[n, c] with NaN where a value is not believed;
    `flags` uint16[n, m], bits of Cause per signal, bits of the whole sample in every column.
    """

    stamp: np.ndarray
    values: np.ndarray
    flags: np.ndarray

    def __iter__(self):
        return iter((self.stamp, self.values, self.flags))

    @property
    def kept(self) -> np.ndarray:
        """bool[n]: False for samples that repeat a stamp."""
        return (self.flags[:, 0] & Cause.REPEATED) == 0


class StreamScreen:
    """Screening of one topic, with all that must be remembered between chunks.

    `topic` is relative. `noise` maps the keys of the rig sheet's sensors (`speed`, `pressure`,
    `temperature`, ...) to the standard deviation of one sample in SI; a key that is absent or 0
    turns the judgement of stuck values off. `scales` of the rig make the judgement of units a sharper one and tell
    the full scale of the sensors. Values are SI inside,
    temperatures in kelvin. `stops` are the lengths, s, of the last times that the stream stopped, for a listener; it empties them.
    """

    def __init__(
        self,
        topic: str,
        noise: Mapping[str, float] | None = None,
        reorder_window: float = REORDER_WINDOW,
        scales: UnitScales | None = None,
    ) -> None:
        self.topic = topic
        self.signals: tuple[Signal, ...] = signals_of(topic)
        self.suspicions: list[UnitSuspicion] = []
        self.stops: deque[float] = deque(maxlen=_MOST_STOPS)
        self.noise = np.array([(noise or {}).get(s.noise_key, 0.0) or 0.0 for s in self.signals], float)
        self._window = to_ns(reorder_window)
        self._scales = scales
        fields = len(self.signals)
        most = max(len(s.mistakes) for s in self.signals)
        self._raised: Set[tuple[int, ...]] = set()
        self._limits = np.array([(s.lowest, s.highest) for s in self.signals])
        full_scale = scales.full_scale if scales is not None else {}
        self._full_scale = np.array([full_scale.get(s.noise_key, np.inf) for s in self.signals])
        self._ends = np.full(fields, np.inf)
        self._mistakes = np.full((fields, most, 5), np.nan)
        for j, signal in enumerate(self.signals):
            for k, mistake in enumerate(signal.mistakes):
                lowest, highest = signal.usual
                least = _REACHED * max(abs(signal.lowest), abs(signal.highest)) if mistake.factor >= _THOUSANDFOLD else 0.0
                self._mistakes[j, k] = (mistake.factor, mistake.offset, max(signal.lowest, lowest), min(signal.highest, highest), least)
        rules = rules_of(topic)
        self._rules = np.array([(r.kind, r.a, r.b, r.c, r.d, r.window) for r in rules], np.int64).reshape(-1, 6)
        self._floors = np.array([r.floor for r in rules], float)
        self._stream = np.zeros(kernel.STREAM_ENTRIES, np.int64)
        self._ring = np.zeros(kernel.RING, np.int64)
        self._periods = np.zeros(kernel.FIRST_PERIODS, np.int64)
        self._field_state = np.zeros((fields, kernel.FIELD_COLUMNS))
        self._field_state[:, (kernel.LAST, kernel.QUANTUM)] = np.nan
        self._suspect = np.zeros(fields, bool)
        self._mistaken, self._reached = np.ones((fields, most), bool), np.zeros((fields, most), bool)
        self._fractions = False  # whether a temperature that is out of range had digits behind the point
        self._rule_state = np.zeros((len(rules), kernel.RULE_COLUMNS))
        self._largest = np.zeros(len(rules))  # that each rule has seen
        self._standing: list[UnitSuspicion] = []
        self._counts = np.zeros((kernel.CAUSES, fields), np.int64)
        self._first = np.zeros((kernel.CAUSES, fields), np.int64)
        self._first_value = np.full((kernel.CAUSES, fields), np.nan)
        self._stuck_since = np.zeros(fields, np.int64)  # where the first run of a stuck field began

    def screen(self, stamp_ns: np.ndarray | Sequence[int], values: np.ndarray) -> Screened:
        """Judge samples in order of arrival: stamps int64[n] ns, values float64[n, c].

        The first columns of `values` are the topic's signals in their order; further ones
        (a variance) pass unchanged. The input is not changed.
        """
        stamp = np.array(stamp_ns, np.int64, ndmin=1)
        given, values = values, np.array(values, float, ndmin=2)
        flags = np.empty((stamp.size, len(self.signals)), np.uint16)
        newest = self.newest_ns
        told, before = self._counts[_STUCK].copy(), self._field_state[:, : kernel.RUN_SINCE + 1].copy()
        done = 0
        while done < stamp.size:
            done = kernel.screen(
                stamp,
                values,
                self._limits,
                np.minimum(self._full_scale, self._ends),
                self.noise,
                self._rules,
                self._floors,
                self._mistakes,
                self._stream,
                self._ring,
                self._periods,
                self._field_state,
                self._suspect,
                self._mistaken,
                self._reached,
                self._rule_state,
                self._counts,
                self._first,
                self._first_value,
                flags,
                self._window,
                done,
                kernel.EVIDENCE,
            )
            if np.any(self._rule_state[self._rules[:, kernel.WINDOW] > 0, kernel.RULE_COUNT] >= kernel.EVIDENCE):
                self._judge_units()
        if TENTHS in self.signals[0].mistakes and not self._fractions:
            beyond = np.array(given, float, ndmin=2)[(flags[:, 0] & Cause.OUT_OF_RANGE) > 0, 0] - ZERO_CELSIUS
            self._fractions = bool(np.any(np.abs(beyond - np.round(beyond)) > _WHOLE))
        for j in np.flatnonzero((told == 0) & (self._counts[_STUCK] > 0)):
            self._stuck_since[j] = self._run_began(j, stamp, np.array(given, float, ndmin=2)[:, j], flags[:, j], before[j])
        if (stops := np.flatnonzero(flags[:, 0] & Cause.GAP)).size:
            rising = np.flatnonzero((flags[:, 0] & (Cause.OUT_OF_ORDER | Cause.REPEATED)) == 0)
            for i, place in zip(stops, np.searchsorted(rising, stops), strict=True):
                self.stops.append(float(stamp[i] - (stamp[rising[place - 1]] if place else newest)) * 1e-9)
        return Screened(stamp, values, flags)

    def find_ends(self, values: np.ndarray) -> None:
        """Learn from all readings, float64[n, c], before they are screened, at which pressure its transducer ends; see `sensor_end`."""
        for j, signal in enumerate(self.signals):
            if signal.noise_key == "pressure":
                self._ends[j] = sensor_end(values[:, j], self.noise[j])

    def _run_began(self, j: int, stamp: np.ndarray, given: np.ndarray, flags: np.ndarray, before: np.ndarray) -> int:
        """Stamp, ns, of the first repetition of the value that field j was first found stuck at."""
        found = int(np.argmax(flags & Cause.STUCK > 0))
        judged = np.flatnonzero((flags[: found + 1] & _NOT_IN_RUNS) == 0)
        breaks = np.flatnonzero((given[judged] != given[found]) | (flags[judged] & Cause.CLOCK_JUMP > 0))
        if not breaks.size and before[kernel.LAST] == given[found]:
            return int(before[kernel.RUN_SINCE])  # it began in an earlier chunk
        last = breaks[-1] if breaks.size else -1
        same = last >= 0 and given[judged[last]] == given[found]  # the clock jumped there
        return int(stamp[judged[last if same else last + 1]])

    def reject_whole_runs(self, given: np.ndarray, screened: Screened) -> None:
        """Reject what a stuck field repeated before that was noticed, where all its samples are there.

        `given` float64[n, c] are the values before screening, in which a run that is found stuck
        (`Cause.STUCK`) is followed back to the first repetition; zeros of a machine that is
        switched off are left. Values, flags and findings are changed.
        """
        stamp, values, flags = screened
        scale = np.abs(given[:, : len(self.signals)]) > kernel.ALIVE * self.noise
        scale &= self.noise > 0.0
        for j in np.flatnonzero((flags & Cause.STUCK).any(axis=0)):
            judged = np.flatnonzero((flags[:, j] & _NOT_IN_RUNS) == 0)
            value = given[judged, j]
            new = np.ones(judged.size, bool)
            new[1:] = (value[1:] != value[:-1]) | (flags[judged[1:], j] & Cause.CLOCK_JUMP > 0)
            run = np.cumsum(new) - 1
            stuck = np.zeros(run[-1] + 1, bool)
            stuck[run[flags[judged, j] & Cause.STUCK > 0]] = True
            others = scale.sum(axis=1) - scale[:, j] > 0
            rejected = judged[stuck[run] & ((value != 0.0) | others[judged])]
            values[rejected, j] = np.nan
            flags[rejected, j] |= np.uint16(Cause.STUCK)
            self._counts[_STUCK, j] = rejected.size
            self._first[_STUCK, j] = self._stuck_since[j] = stamp[rejected[0]]

    def _judge_units(self) -> None:
        """Believe a suspicion that two windows of evidence in a row have raised."""
        self._largest = np.maximum(self._largest, self._rule_state[:, kernel.RULE_A])
        with np.errstate(over="ignore", invalid="ignore"):  # sums of readings near the largest float tell nothing
            verdict = judge(self.topic, self._rule_state, self.noise, self._largest, self._scales, self._standing)
        self._rule_state[:] = 0.0
        raised = {s.fields: s for s in verdict}
        self._standing = [raised[fields] for fields in raised if fields in self._raised]
        self._suspect[:] = False
        for suspicion in self._standing:
            self._suspect[list(suspicion.fields)] = True
            told = [s for s in self.suspicions if s.fields == suspicion.fields]
            if not told or len(suspicion.units) < len(told[0].units):
                self.suspicions = [*(s for s in self.suspicions if s not in told), suspicion]
        self._raised = raised.keys()

    @property
    def segment(self) -> int:
        """How often the clock has jumped back."""
        return int(self._stream[kernel.SEGMENT])

    @property
    def period(self) -> float | None:
        """Typical interval between samples in s, None before it is known."""
        known = self._stream[kernel.PERIODS] == kernel.FIRST_PERIODS
        return float(self._stream[kernel.PERIOD]) * 1e-9 if known else None

    @property
    def newest_ns(self) -> int | None:
        """Newest stamp since the clock last jumped back, None before the first sample."""
        return int(self._stream[kernel.NEWEST]) if self._stream[kernel.COUNT] else None

    def count(self, cause: Cause, field: str | None = None) -> int:
        """How often a cause struck, in one field or (None) over all."""
        row = self._counts[CAUSES.index(cause)]
        if field is None:
            return int(row.sum())
        return int(row[[s.field for s in self.signals].index(field)])

    def health(self) -> dict[str, int]:
        """Counts for diagnostics, in fixed order: samples, then every cause by its name."""
        counts = {"samples": int(self._stream[kernel.COUNT])}
        for cause in CAUSES:
            counts[cause.name.lower()] = self.count(cause)
        return counts

    @property
    def _explaining(self) -> np.ndarray:
        """Mistakes of unit that explain all of a field that is out of range, bool[m, k]; tenths of a degree are whole numbers where it
        may be in K instead."""
        explaining = self._mistaken & self._reached
        if self._fractions:
            kelvin, tenths = (self.signals[0].mistakes.index(unit) for unit in (KELVIN, TENTHS))
            explaining[0, tenths] &= not explaining[0, kelvin]
        return explaining

    def in_another_unit(self) -> dict[int, tuple[UnitMistake, ...]]:
        """Fields, by number, of which so many samples are out of range that all look as if given in another unit, and which it may be."""
        out_of_range = self._counts[CAUSES.index(Cause.OUT_OF_RANGE)]
        return in_another_unit(self.signals, out_of_range, int(self._stream[kernel.COUNT]), self._explaining)

    def begins_in_another_unit(self, least: int) -> dict[int, tuple[UnitMistake, ...]]:
        """The same of fields all of whose samples so far, ``least`` or more, are out of range."""
        samples, out_of_range = int(self._stream[kernel.COUNT]), self._counts[CAUSES.index(Cause.OUT_OF_RANGE)]
        if samples < least:
            return {}
        told = {j: tuple(m for m, still in zip(signal.mistakes, self._explaining[j], strict=False) if still)
                for j, signal in enumerate(self.signals) if out_of_range[j] == samples}
        return {j: units for j, units in told.items() if units}

    def findings(self, file: str = "", topic: str | None = None, epoch_ns: int = 0, whole: bool = False,
                 unit: UnitMistake | None = None) -> list[Finding]:
        """One finding per cause and field. `topic` as people know it (default: relative name).

        Times in the findings are s relative to `epoch_ns`. ``whole``: fields `in_another_unit` are not used at all. ``unit``: in which
        such a field is, as others tell.
        """
        counted = Counted(self.signals, int(self._stream[kernel.COUNT]), self._counts, self._first, self._first_value, self._explaining,
                          self.noise, self._full_scale, self._ends, self._stuck_since, self.suspicions)
        return findings_of(counted, file, topic or self.topic, epoch_ns, whole, unit)


def screen_recording(
    recording: Recording,
    noise: Mapping[str, float] | None = None,
    reorder_window: float = REORDER_WINDOW,
    scales: UnitScales | None = None,
) -> Recording:
    """Screen all streams of a recording.

    Returned streams are sorted by stamp (within the stretches between clock jumps), repeated
    samples are left out, values that are not believed are NaN; findings are appended. A field
    in a wrong unit is rejected from the beginning and one that is stuck from its first
    repetition, not from where that was noticed.
    """
    streams: dict[str, Stream] = {}
    refused: dict[str, tuple[UnitMistake, ...]] = {}
    screens: dict[str, StreamScreen] = {}
    findings = list(recording.findings)
    stamps = {topic: stream.stamps(recording.epoch_ns) for topic, stream in recording.streams()}
    segments = clock_segments(stamps, to_ns(reorder_window))
    for topic, stream in recording.streams():
        screens[topic] = screen = StreamScreen(topic, noise, reorder_window, scales)
        if topic == HYDRAULIC_TOPIC:
            screen.find_ends(stream.values)
        screened = screen.screen(stamps[topic], stream.values)
        _, values, flags = screened
        if screen.count(Cause.STUCK):
            screen.reject_whole_runs(stream.values, screened)
        for suspicion in screen.suspicions:
            for column in suspicion.fields:
                suspect = np.flatnonzero(flags[:, column] & Cause.WRONG_UNIT)
                values[: 1 + suspect.max(initial=-1), column] = np.nan
        for column, units in screen.in_another_unit().items():
            values[:, column] = np.nan
            if topic.startswith(TEMPERATURE_PREFIX):
                refused[topic] = units
        order = sorted_order(stamps[topic], segments[topic])
        streams[topic] = Stream(stream.time[order], values[order], stream.fields)
    units = likely_units(first_readings(recording), refused)
    for topic, screen in screens.items():
        findings += screen.findings(recording.path, f"{recording.namespace}/{topic}", recording.epoch_ns, whole=True, unit=units.get(topic))
    for topic, finding in alike_units(recording, units).items():
        streams[topic].values[:, 0] = np.nan
        findings.append(finding)
    for topic, finding in odd_temperatures(recording.with_streams(streams), scales).items():
        streams[topic].values[:, 0] = np.nan
        findings.append(finding)
    for topic, finding in all_zero(recording).items():
        if finding.severity == "error":
            streams[topic].values[:] = np.nan
        findings.append(finding)
    findings += too_seldom(recording) + odd_variances(recording) + clock_set_ahead(recording.with_streams(streams))
    strange = apart(recording)
    findings += strange
    if not strange and not any(segments[topic].any() for topic in segments):
        findings += missing_ends(recording)
    return recording.with_streams(streams, findings)


def screen_by_sheet(recording: Recording, rig: Rig) -> Recording:
    """Screen all streams with what a rig's sheet tells: noise of its sensors, and what size readings have under the payload declared."""
    return screen_recording(recording, {name: spec.noise for name, spec in rig.sensors.items()}, scales=UnitScales.of(rig, recording))
