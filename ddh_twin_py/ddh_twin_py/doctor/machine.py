"""Does a running machine publish what the interface wants: topics, types, rates, stamps, values."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.bags.cdr import MOST_NANOSEC, first_odd_nanosec
from ddh_twin_py.bags.message_types import know
from ddh_twin_py.bags.topics import nearest_telemetry, split_topic
from ddh_twin_py.doctor.check import Check
from ddh_twin_py.doctor.middleware import came_late
from ddh_twin_py.doctor.survey import HeardTopic, Survey
from ddh_twin_py.rig import PAYLOADS, is_payload
from ddh_twin_py.telemetry.clocks.clock import PUT_BACK
from ddh_twin_py.telemetry.clocks.other_clocks import outvoted
from ddh_twin_py.telemetry.clocks.stream_line import LONGEST_LAG
from ddh_twin_py.telemetry.recording import Recording, Stream
from ddh_twin_py.telemetry.screening.screening import screen_recording
from ddh_twin_py.telemetry.signals import (
    BESIDE_SENSORS,
    DRIVE_TOPIC,
    HYDRAULIC_TOPIC,
    MACHINE_FIELDS,
    RATES,
    RIG_TOPIC,
    RIG_TYPE,
    TEMPERATURE_FIELDS,
    TEMPERATURE_PREFIX,
    TOPIC_TYPES,
    ZERO_CELSIUS,
)
from ddh_twin_py.telemetry.units.unit_scales import UnitScales

GROUP = "machine"
_SLACK = 1.05  # of a rate, before it is called too low or too high
LATEST = 0.5
"""s between stamp and arrival, and between two streams, up to which the twin sorts messages in."""
_FEW = 3  # messages that tell a rate
_NEED = {
    DRIVE_TOPIC: ("error", "the twin is driven by it"),
    HYDRAULIC_TOPIC: ("warning", "the model's own pressures are used instead and the estimate is less sure"),
    TEMPERATURE_PREFIX + "ambient": ("warning", "the ambient temperature of the rig file is used instead"),
    RIG_TOPIC: ("warning", "payload and rig id of the rig file are used instead"),
}


def machines(survey: Survey) -> list[str]:
    """Namespaces in which somebody publishes telemetry, '' is the root."""
    found = set()
    for name, heard in survey.topics.items():
        split = split_topic(name)
        if split is not None and heard.publishers and split[1] in (DRIVE_TOPIC, HYDRAULIC_TOPIC):
            found.add(split[0])
    return sorted(found)


def check_machine(survey: Survey, namespace: str, noise: Mapping[str, float], scales: UnitScales | None = None) -> list[Check]:
    """All judgements of the machine in one namespace ('' or with a leading slash).

    Args:
        noise: by sensor, SI, for the screening. scales: of the rig, for the same.
    """
    checks = []
    streams: dict[str, Stream] = {}
    offsets: dict[str, float] = {}
    stamps_of: dict[str, np.ndarray] = {}
    for relative, expected in TOPIC_TYPES.items():
        heard = survey.topics.get(f"{namespace}/{relative}")
        if heard is None or not heard.publishers:
            if relative in _NEED:
                checks.append(_missing(survey, namespace, relative))
            continue
        wrong = _announced(heard, expected)
        checks += wrong
        if any(check.level == "error" for check in wrong):
            continue
        if relative == RIG_TOPIC:
            checks.append(_rig(heard))
            continue
        stamps, values, sound = _decoded(heard, relative)
        checks += _rate(heard, relative, survey.seconds)
        if nanosec := first_odd_nanosec(heard.messages):
            checks.append(Check(GROUP, heard.topic, "error", f"header.stamp nanosec {nanosec}", f"0 to {MOST_NANOSEC}",
                                "give whole seconds as sec"))
        elif not sound.all():
            checks.append(Check(GROUP, heard.topic, "error", "messages cannot be decoded", expected, "build ddh_msgs of both sides anew"))
        if stamps.size:
            stamps_of[relative], streams[relative] = stamps, values
            offsets[relative] = float(np.median(heard.arrived[sound] - stamps)) * 1e-9
    checks += _clocks(namespace, offsets, stamps_of, survey.clock_published, came_late(survey))
    stamps_of = {relative: stamp + round(offsets[relative] * 1e9) for relative, stamp in stamps_of.items()}  # as by one clock
    return checks + _values(namespace, streams, stamps_of, noise, scales)


def _missing(survey: Survey, namespace: str, relative: str) -> Check:
    level, consequence = _NEED[relative]
    name = f"{namespace}/{relative}"
    known = {f"{namespace}/{topic}" for topic in (*TOPIC_TYPES, *BESIDE_SENSORS)}
    similar = next((other for other in sorted({*survey.other_topics, *survey.topics} - known)
                    if f"{namespace}/{nearest_telemetry(other, namespace)}" == name), "")
    advice = f"publish it; {consequence}" + (f"; did {similar} mean it?" if similar else "")
    return Check(GROUP, name, level, "nobody publishes it", TOPIC_TYPES[relative], advice)


def _announced(heard: HeardTopic, expected: str) -> list[Check]:
    checks = []
    if set(heard.types) != {expected}:
        checks.append(Check(GROUP, heard.topic, "error", f"type {' and '.join(heard.types)}", expected,
                            f"{', '.join(heard.publishers)}: publish {expected}"))
    if len(heard.publishers) > 1:
        checks.append(Check(GROUP, heard.topic, "error", f"{len(heard.publishers)} publishers: {', '.join(heard.publishers)}", "1",
                            "stop all but one: their messages are mixed"))
    return checks


def _decoded(heard: HeardTopic, relative: str) -> tuple[np.ndarray, Stream, np.ndarray]:
    """Stamps and values of the messages that are sound, and which of all these are."""
    fields = MACHINE_FIELDS.get(relative, TEMPERATURE_FIELDS)
    stamps, values, sound = heard.floats(len(fields))
    stamps, values = stamps[sound], values[sound]
    if relative.startswith(TEMPERATURE_PREFIX):
        values[:, 0] += ZERO_CELSIUS
    return stamps, Stream(stamps * 1e-9, values, fields), sound


def _rate(heard: HeardTopic, relative: str, seconds: float) -> list[Check]:
    low, high = RATES[TEMPERATURE_PREFIX if relative.startswith(TEMPERATURE_PREFIX) else relative]
    right, count = f"{low:g} to {high:g} per second", heard.arrived.size
    if count < _FEW:
        enough = seconds * low > _FEW
        advice = f"{', '.join(heard.publishers)} announces it and sends nothing" if not count else "it comes more seldom than it should"
        return [Check(GROUP, heard.topic, "error" if enough and relative in MACHINE_FIELDS else "warning" if enough else "note",
                      f"{count} messages in {seconds:.0f} s", right, advice if enough else "listen longer: --seconds 60")]
    rate = heard.rate()
    found = f"{rate:.3g} per second"
    if rate * _SLACK < low:
        return [Check(GROUP, heard.topic, "warning", found, right, "publish it more often: what happens between two samples is lost")]
    if rate > high * _SLACK:
        return [Check(GROUP, heard.topic, "warning", found, right, "publish it less often: it costs processor time and tells no more")]
    return [Check(GROUP, heard.topic, "ok", found, right)]


def _rig(heard: HeardTopic) -> Check:
    if not heard.latched:
        return Check(GROUP, heard.topic, "warning", "not transient local", "transient local, reliable",
                     "a twin that starts later does not get it: publish with transient local durability")
    if not heard.messages:
        return Check(GROUP, heard.topic, "warning", "nothing came", "one message", f"{', '.join(heard.publishers)} must publish it once")
    message = know(RIG_TYPE).deserialize_cdr(heard.messages[-1], RIG_TYPE)
    found = f"{message.rig_id or 'no rig_id'}, {message.oil_grade or 'no oil grade'}, payload {message.payload_mass:g} kg"
    right = f"payload_mass {PAYLOADS}"
    if not is_payload(message.payload_mass):
        return Check(GROUP, heard.topic, "warning", found, right, "say what the rod lifts; the rig file's is used instead")
    return Check(GROUP, heard.topic, "ok", found, f"rig_id, oil grade, {right}")


def _clocks(namespace: str, offsets: Mapping[str, float], stamps: Mapping[str, np.ndarray], simulated: bool, late: bool) -> list[Check]:
    """What is said of stamps. ``late``: messages came too late here, which looks as if stamps of some seconds ago were of another clock."""
    if not offsets:
        return []
    busy = ("as said of messages between processes, this computer is busy or discovery was late, which looks the same: ask again when it "
            "is not, before clocks are blamed; ")
    checks = []
    first = _usual(offsets)
    found, right = f"stamps are {_apart(offsets[first])} this computer's clock", f"0 to {LATEST:g} s behind"
    if -0.05 <= offsets[first] <= LATEST:
        checks.append(Check(GROUP, "stamps", "ok", found, right))
    elif simulated:
        checks.append(Check(GROUP, "stamps", "note", f"{found}; /clock is published", right, "a recording is played: nothing to do"))
    else:
        checks.append(Check(GROUP, "stamps", "warning", found, right, busy * (late and 0.0 <= offsets[first] <= LONGEST_LAG) +
                            "keep the clocks of both computers in step (chrony, PTP), and stamp with the time of measurement"))
    lost = outvoted({relative: round(-offset * 1e9) for relative, offset in offsets.items()})
    for relative, offset in offsets.items():
        topic, behind, within = f"{namespace}/{relative}", offset - offsets[first], f"within {LATEST:g} s"
        if relative in lost:
            checks.append(Check(GROUP, topic, "error", f"its stamps lie {_apart(-lost[relative] * 1e-9)} those of most streams", within,
                                "the twin leaves it out and goes on as without it: stamp it by the clock of the others"))
        elif abs(behind) > LATEST:
            happens = ("the twin takes what they tell at once for as far apart" if abs(behind) <= LONGEST_LAG else
                       "the twin believes one of the two and leaves the other out")
            checks.append(Check(GROUP, topic, "warning", f"its stamps lie {_apart(behind)} those of {first}", within,
                                f"{busy * (late and abs(behind) <= LONGEST_LAG)}the streams must be stamped by one clock; {happens}"))
    for relative, stamp in stamps.items():
        back = np.diff(stamp)
        if (back < -LATEST * 1e9).any():
            checks.append(Check(GROUP, f"{namespace}/{relative}", "warning",
                                f"stamps jump back by up to {-back.min() * 1e-9:.1f} s", "never",
                                f"where all do, by more than {PUT_BACK:g} s, the twin starts anew; a stream that does alone is left out"))
    return checks


def _usual(offsets: Mapping[str, float]) -> str:
    """The first stream of those that are stamped as most are, of as many by this computer's clock."""
    alike = {one: sum(abs(offset - other) <= LATEST for other in offsets.values()) for one, offset in offsets.items()}
    return max(offsets, key=lambda one: (alike[one], -round(abs(offsets[one]) / LATEST)))


def _apart(seconds: float) -> str:
    return f"{abs(seconds):.{'3g' if abs(seconds) < 100.0 else '0f'}} s {'behind' if seconds >= 0.0 else 'ahead of'}"


def _values(namespace: str, streams: Mapping[str, Stream], stamps: Mapping[str, np.ndarray], noise: Mapping[str, float],
            scales: UnitScales | None) -> list[Check]:
    """What the screening of the twin says of the samples."""
    if not streams:
        return []
    epoch = min(int(stamp.min()) for stamp in stamps.values())
    told = {name: Stream((stamps[name] - epoch) * 1e-9, stream.values, stream.fields) for name, stream in streams.items()}
    recording = Recording("live", epoch, None, None, None, namespace=namespace).with_streams(told)
    findings = [finding for finding in screen_recording(recording, noise, scales=scales).findings if finding.severity != "info"]
    checks = [Check(GROUP, finding.topic or "samples", finding.severity, finding.message.removeprefix("live: "), "",
                    "the twin leaves such values out; look at sensor, wiring and unit") for finding in findings]
    count = sum(len(stream) for stream in streams.values())
    return checks or [Check(GROUP, "samples", "ok", f"{count} samples, all finite, in range, in a likely unit", "")]
