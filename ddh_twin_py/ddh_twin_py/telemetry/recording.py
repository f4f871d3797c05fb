"""The recording of one rig as arrays, with what was found wrong in it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from ddh_twin_py.rig.files import printable

from .signals import (
    DRIVE_FIELDS,
    DRIVE_TOPIC,
    HYDRAULIC_FIELDS,
    HYDRAULIC_TOPIC,
    RIG_TOPIC,
    TEMPERATURE_FIELDS,
    TEMPERATURE_PREFIX,
    TEMPERATURE_SENSORS,
    ZERO_CELSIUS,
)

SEVERITIES = ("info", "warning", "error")
SLIGHT = 0.01
"""Share of a topic's samples that a slight warning strikes at most."""


@dataclass(frozen=True)
class Finding:
    """One cause found in the input, however often it struck.

    `severity`: info, warning or error. `file`, `topic` and `field` say where ('' where it does
    not apply), `value` the first offending value in the unit of the message (None where there
    is none), `count` how often, `first_time` when first (s relative to the recording's epoch,
    NaN where unknown). `message` is a whole sentence naming all of these. `mended`: what it struck is left out
    or sorted in, and the rest is as good as before.
    """

    severity: str
    file: str
    topic: str
    field: str
    value: float | str | None
    count: int
    message: str
    first_time: float = float("nan")
    mended: bool = False

    def __str__(self) -> str:
        return f"{self.severity}: {self.message}"

    def slight(self, samples: int) -> bool:
        """Whether it strikes at most `SLIGHT` of a topic's so many samples, which are mended."""
        return self.mended and self.severity == "warning" and self.count <= SLIGHT * samples


@dataclass(frozen=True)
class RigInfo:
    """Which rig was recorded: `rig_id`, `oil_grade` such as "ISO VG 32", `payload_mass` in kg (NaN: not known)."""

    rig_id: str
    oil_grade: str
    payload_mass: float

    def __str__(self) -> str:
        payload = f"payload {self.payload_mass:g} kg" if self.payload_mass == self.payload_mass else "payload not known"
        return f"{self.rig_id or 'not named'}, {self.oil_grade or 'oil not known'}, {payload}"


@dataclass(frozen=True)
class Stream:
    """Samples of one topic.

    `time` float64[n]: header stamps, s relative to the recording's epoch. `values`
    float64[n, m], one column per name in `fields`, SI (temperatures K). A rejected or missing
    value is NaN. As read from a bag the order is that of arrival; screening sorts.
    Raises ValueError when the shapes do not fit.
    """

    time: np.ndarray
    values: np.ndarray
    fields: tuple[str, ...]

    def __post_init__(self) -> None:
        if self.values.ndim != 2 or self.values.shape != (self.time.size, len(self.fields)):
            raise ValueError(
                f"a stream of {self.time.size} stamps and fields {self.fields} needs values of "
                f"shape {(self.time.size, len(self.fields))}, not {self.values.shape}"
            )

    def __len__(self) -> int:
        return self.time.size

    def column(self, name: str) -> np.ndarray:
        """Values of one field, float64[n]. Raises KeyError naming the valid fields."""
        try:
            return self.values[:, self.fields.index(name)]
        except ValueError:
            raise KeyError(f"no field {name!r}; valid are {', '.join(self.fields)}") from None

    def stamps(self, epoch_ns: int) -> np.ndarray:
        """Header stamps, int64[n] ns, exact within 50 days of the epoch."""
        return np.rint(self.time * 1e9).astype(np.int64) + np.int64(epoch_ns)

    def between(self, start: float, stop: float) -> Stream:
        """Samples with start <= time < stop (s relative to the epoch), order kept."""
        chosen = (self.time >= start) & (self.time < stop)
        return Stream(self.time[chosen], self.values[chosen], self.fields)


def drive_stream(time: np.ndarray, values: np.ndarray) -> Stream:
    """Stream of `drive/telemetry` with values float64[n, 6] in the order of DRIVE_FIELDS."""
    return Stream(time, values, DRIVE_FIELDS)


def hydraulic_stream(time: np.ndarray, values: np.ndarray) -> Stream:
    """Stream of `hydraulics/telemetry`, values float64[n, 4] in the order of HYDRAULIC_FIELDS."""
    return Stream(time, values, HYDRAULIC_FIELDS)


def temperature_stream(time: np.ndarray, kelvin: np.ndarray, variance=0.0) -> Stream:
    """Stream of one sensor: float64[n] K and its variance in K2 (0: unknown)."""
    values = np.empty((time.size, 2))
    values[:, 0] = kelvin
    values[:, 1] = variance
    return Stream(time, values, TEMPERATURE_FIELDS)


@dataclass(frozen=True)
class Recording:
    """What one rig's sensors said, as arrays.

    `epoch_ns` is the oldest header stamp in ns; all times are s relative to it.
    `temperatures` maps sensor name to a stream in kelvin, in the order of TEMPERATURE_SENSORS;
    sensors that were not recorded are absent. `findings` lists what was wrong.
    """

    path: str
    epoch_ns: int
    rig: RigInfo | None
    drive: Stream | None
    hydraulic: Stream | None
    temperatures: dict[str, Stream] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    namespace: str = ""

    def held_against(self, oil_grade: str) -> Recording:
        """The recording beside a rig file whose oil is of a grade, "" of none: another oil is a finding, the same one is none."""
        if self.rig is None or not oil_grade:
            return self
        told = [finding for finding in self.findings if finding.field == "oil_grade"]
        if same_oil(self.rig.oil_grade, oil_grade):
            return replace(self, findings=[finding for finding in self.findings if finding not in told])
        if told or not self.rig.oil_grade.strip():
            return self
        topic = f"{self.namespace}/{RIG_TOPIC}"
        message = (f"{self.path}: topic {topic} oil_grade is '{printable(self.rig.oil_grade)}', the rig file's is {oil_grade!r}; "
                   "the oil of the rig file is used")
        return replace(self, findings=[*self.findings, Finding("warning", self.path, topic, "oil_grade", self.rig.oil_grade, 1, message)])

    def samples(self) -> dict[str, int]:
        """Samples of each topic, by the name that findings give it."""
        return {f"{self.namespace}/{topic}": len(stream) for topic, stream in self.streams()}

    def slight_findings(self) -> list[Finding]:
        """Findings that strike few samples of their topic, in their order; see `Finding.slight`."""
        samples = self.samples()
        return [finding for finding in self.findings if finding.slight(samples.get(finding.topic, 0))]

    def lack_of(self, topic: str) -> str:
        """Why it has no message of a relative topic, in words that name it: all are left out, or there is none."""
        name = f"{self.namespace}/{topic}"
        said = [finding.message.removeprefix(f"{self.path}: ") for finding in self.findings
                if finding.topic == name and finding.field == "header.stamp"]
        return said[0] if said else f"{name}: no message"

    def streams(self) -> Iterator[tuple[str, Stream]]:
        """Pairs of relative topic and stream, drive first, sensors in their fixed order."""
        if self.drive is not None:
            yield DRIVE_TOPIC, self.drive
        if self.hydraulic is not None:
            yield HYDRAULIC_TOPIC, self.hydraulic
        for sensor in TEMPERATURE_SENSORS:
            if sensor in self.temperatures:
                yield TEMPERATURE_PREFIX + sensor, self.temperatures[sensor]

    def with_streams(self, streams: dict[str, Stream], findings=None) -> Recording:
        """The recording with its streams replaced by those of `streams` (by relative topic)."""
        return replace(
            self,
            drive=streams.get(DRIVE_TOPIC),
            hydraulic=streams.get(HYDRAULIC_TOPIC),
            temperatures={
                sensor: streams[TEMPERATURE_PREFIX + sensor]
                for sensor in TEMPERATURE_SENSORS
                if TEMPERATURE_PREFIX + sensor in streams
            },
            findings=list(self.findings if findings is None else findings),
        )

    @property
    def span(self) -> tuple[float, float]:
        """Oldest and newest stamp, s relative to the epoch; (0, 0) without samples."""
        ends = [(s.time.min(), s.time.max()) for _, s in self.streams() if len(s)]
        if not ends:
            return 0.0, 0.0
        return float(min(a for a, _ in ends)), float(max(b for _, b in ends))

    @property
    def duration(self) -> float:
        """Time from the oldest to the newest stamp, s."""
        start, stop = self.span
        return stop - start

    @property
    def warnings(self) -> list[Finding]:
        """Findings that are more than information."""
        return [finding for finding in self.findings if finding.severity != "info"]

    def between(self, start: float, stop: float) -> Recording:
        """The recording from start (included) to stop (excluded), s relative to the epoch.

        The epoch stays, so that times keep their meaning.
        """
        return self.with_streams({topic: stream.between(start, stop) for topic, stream in self.streams()})

    def describe(self) -> str:
        """A few lines for people: rig, duration, streams with rates, findings."""
        lines = [f"{self.path}: {self.duration:.1f} s"]
        if self.rig is not None:
            lines.append(f"rig {self.rig}")
        for topic, stream in self.streams():
            lines.append(f"  {topic}: {len(stream)} samples, {_rate(stream.time):.3g} Hz")
        lines += [f"  {finding}" for finding in self.findings]
        return "\n".join(lines)


def _rate(time: np.ndarray) -> float:
    steps = np.diff(time)
    steps = steps[steps > 0]
    return 1.0 / float(np.median(steps)) if steps.size else 0.0


def same_oil(*grades: str) -> bool:
    """Whether names are of one grade of oil: `ISO VG 46` is `vg46`."""
    return len({"".join(grade.split()).upper().removeprefix("ISO") for grade in grades}) == 1


def announced_id(recordings: Iterable[Recording]) -> str:
    """Rig id that the first of some recordings tells that tells one, '' where none does."""
    return next((recording.rig.rig_id for recording in recordings if recording.rig is not None and recording.rig.rig_id), "")


__all__ = [
    "SEVERITIES",
    "ZERO_CELSIUS",
    "Finding",
    "Recording",
    "RigInfo",
    "Stream",
    "announced_id",
    "drive_stream",
    "hydraulic_stream",
    "same_oil",
    "temperature_stream",
]
