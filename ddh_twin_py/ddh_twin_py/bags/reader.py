"""Read a bag into a Recording."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ddh_twin_py.bags.cdr import nanosec_words
from ddh_twin_py.bags.collector import Collector, Rows
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.folder import BagFolder, open_folder
from ddh_twin_py.bags.odd_stamps import odd_stamps
from ddh_twin_py.bags.opening import of_file, open_storage, readable, unpacked
from ddh_twin_py.bags.topics import choose_namespace, nearest_telemetry, split_topic
from ddh_twin_py.bags.wrong_stamps import sound
from ddh_twin_py.names import first_of
from ddh_twin_py.rig import OIL_GRADE, PAYLOADS, is_payload
from ddh_twin_py.telemetry.recording import Finding, Recording, RigInfo, Stream, same_oil
from ddh_twin_py.telemetry.signals import (
    BESIDE_SENSORS,
    DRIVE_TOPIC,
    HYDRAULIC_TOPIC,
    MACHINE_FIELDS,
    RIG_TOPIC,
    TEMPERATURE_FIELDS,
    TEMPERATURE_PREFIX,
    TEMPERATURE_SENSORS,
    ZERO_CELSIUS,
)
from ddh_twin_py.telemetry.spans import UNSTAMPED

_WHOLE = 0.95  # of the messages that a bag should hold, below which what was recovered is not the recording
_MOST_NAMED = 10  # topics that are ignored
_REACH = 30 * 86400 * 10**9  # ns; a stamp older than the others by more is no time of measurement


def read_recording(
    path: str | Path,
    namespace: str | None = None,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Read the telemetry of one rig from a rosbag2 folder or from one .mcap or .db3 file.

    `namespace` is needed only where a bag holds more than one rig. `progress` is called with
    the share read, 0..1. Times are header stamps; streams are in order of arrival and not yet
    screened; temperatures are in kelvin. What is wrong but can be lived with (a recorder that
    was killed, a missing stream, a few stamps far from all others, a topic by another clock,
    other topics) is in `findings`.
    Raises BagError, one line naming file, topic and value, when the bag cannot be used.
    """
    with readable(path):
        folder = open_folder(path)
        collector = Collector(folder.compression_mode == "message", folder.span)
        damage = _read_files(folder, collector, progress)
    file = str(folder.path)
    total = sum(collector.counts.values())
    if not total:
        reason = f": {folder.files[0].name if len(folder.files) == 1 else 'it'} {damage[0]}" if damage else ""
        listed = sum(entry.count for entry in (folder.topics or {}).values())
        raise BagError(f"{file} holds no messages{reason}" if reason or not listed else
                       f"{file} is damaged: its metadata.yaml lists {listed} messages, of which none can be read")
    chosen = choose_namespace(file, collector.types, namespace)
    _refuse_wrong_types(file, chosen, collector)

    findings = _damage_findings(folder, collector, damage)
    rows = {
        relative: rows.joined()
        for topic, rows in collector.rows.items()
        if (relative := _within(topic, chosen)) and relative != RIG_TOPIC and rows.stamp
    }
    rows = {relative: part for relative, part in rows.items() if part.stamp.size}
    odd = _odd_nanosec_findings(file, chosen, collector.rows)
    if not rows:
        why = f": {odd[0].message.removeprefix(f'{file}: ')}" if odd else ""
        raise BagError(f"{file} has no readable message on {chosen}/{DRIVE_TOPIC} or any other telemetry topic{why}")
    rows, left_out = sound(rows)
    epoch = _epoch([part.stamp for part in rows.values()])
    findings += [wrong.finding(file, chosen, epoch) for wrong in left_out] + odd_stamps(rows, file, chosen, epoch)
    streams = {relative: _stream(relative, part.stamp, part.values, epoch) for relative, part in rows.items()}
    rig, rig_findings = _rig(file, chosen, collector)
    findings += odd + _unreadable_findings(file, chosen, collector.rows)
    findings += _missing_findings(file, chosen, streams, collector) + rig_findings
    findings += _other_topics(file, chosen, collector) + _no_length(file, streams, epoch)
    return Recording(file, epoch, rig, None, None, {}, [], chosen).with_streams(streams, findings)


def _read_files(folder: BagFolder, collector: Collector, progress) -> list[str]:
    """Read all files; what could not be read, with the file's name where there are several."""
    hashes = {topic: entry.type_hash for topic, entry in (folder.topics or {}).items()}
    damage: list[str] = []
    parts = len(folder.files)
    with tempfile.TemporaryDirectory(prefix="ddh_bag_") as scratch:
        for index, file in enumerate(folder.files):
            storage = open_storage(unpacked(file, Path(scratch)))
            share = None
            if progress is not None:

                def share(position, index=index):
                    progress((index + position) / parts)

            collector.read(storage, hashes, share)
            if share is not None:
                share(1.0)
            damage += of_file(storage.damage, file, folder.files)
            folder.remarks += of_file(storage.remarks, file, folder.files)
    return damage


def _within(topic: str, namespace: str) -> str:
    """Relative name of a telemetry topic of the namespace, '' for any other."""
    split = split_topic(topic)
    return split[1] if split and split[0] == namespace else ""


def _refuse_wrong_types(file: str, namespace: str, collector: Collector) -> None:
    for topic, problem in collector.problems.items():
        if _within(topic, namespace):
            raise BagError(f"{file}: topic {topic} {problem}")


def _epoch(stamps: list[np.ndarray]) -> int:
    """Oldest stamp that lies near the others, ns."""
    near = int(np.median([np.median(s) for s in stamps])) - _REACH
    return min(int(s[s >= near].min()) for s in stamps if (s >= near).any())


def _stream(relative: str, stamp: np.ndarray, values: np.ndarray, epoch: int) -> Stream:
    if relative.startswith(TEMPERATURE_PREFIX):
        fields = TEMPERATURE_FIELDS
        values[:, 0] += ZERO_CELSIUS
    else:
        fields = MACHINE_FIELDS[relative]
    return Stream((stamp - epoch) * 1e-9, values, fields)


def _rig(file: str, namespace: str, collector: Collector) -> tuple[RigInfo | None, list[Finding]]:
    topic = f"{namespace}/{RIG_TOPIC}"
    rigs = collector.rigs.get(topic, [])
    if not rigs:
        message = f"{file} has no message on {topic}: payload and oil grade must come from elsewhere"
        return None, [Finding("warning", file, topic, "", None, 1, message)]
    names = sorted({rig.rig_id for rig in rigs} - {""})
    if len(names) > 1:
        listed = " and ".join(repr(n) for n in names)
        raise BagError(f"{file}: topic {topic} names {len(names)} rigs, {listed}; a recording is of one rig")
    used = next((number for number, rig in enumerate(rigs) if is_payload(rig.payload_mass)), 0)
    rig, findings = _usable(file, topic, rigs[used])
    others = [other for other in rigs if (other.payload_mass, other.oil_grade) != (rigs[used].payload_mass, rigs[used].oil_grade)]
    if others and is_payload(rig.payload_mass):
        first, then = (rigs[0], rigs[used] if used else others[0])
        which = f"number {used + 1} of {len(rigs)}, whose payload is the first that is a mass," if used else "the first"
        message = (
            f"{file}: topic {topic} says payload {first.payload_mass:g} kg and '{first.oil_grade}' first, "
            f"then {then.payload_mass:g} kg and '{then.oil_grade}'; {which} is used"
        )
        findings.append(Finding("warning", file, topic, "payload_mass", others[0].payload_mass, len(others), message))
    return replace(rig, rig_id=next(iter(names), "")), findings


def _usable(file: str, topic: str, rig: RigInfo) -> tuple[RigInfo, list[Finding]]:
    """The rig with a payload that is a mass or NaN, and what is said about payload and oil."""
    findings = []
    if not is_payload(rig.payload_mass):
        message = (
            f"{file}: topic {topic} payload_mass is {rig.payload_mass:g} kg, allowed are {PAYLOADS}; "
            "the rig file's payload is taken instead"
        )
        findings.append(Finding("warning", file, topic, "payload_mass", rig.payload_mass, 1, message))
        rig = replace(rig, payload_mass=float("nan"))
    if not same_oil(rig.oil_grade, OIL_GRADE):
        given = f"'{rig.oil_grade}'" if rig.oil_grade.strip() else "not told"
        message = (
            f"{file}: topic {topic} oil_grade is {given}, the reference sheet's is {OIL_GRADE!r}; the oil of the rig file is "
            "used (another one: oil: {grade: ISO VG 46} in a file for --rig)"
        )
        severity = "warning" if rig.oil_grade.strip() else "info"
        findings.append(Finding(severity, file, topic, "oil_grade", rig.oil_grade, 1, message))
    return rig, findings


def _damage_findings(folder: BagFolder, collector: Collector, damage: list[str]) -> list[Finding]:
    file = str(folder.path)
    notes = folder.notes + damage
    remarks = folder.remarks + ([] if notes else folder.contradicted(collector.types, collector.first, collector.last))
    findings = [Finding("warning", file, "", "", None, 1, f"{file} {remark}") for remark in remarks]
    total = sum(collector.counts.values())
    expected = sum(entry.count for entry in (folder.topics or {}).values())
    short = folder.topics is not None and folder.path.is_dir() and total < expected
    miscounted = "" if notes else folder.miscounted(collector.counts)
    if miscounted and not short:
        findings.append(Finding("warning", file, "", "", total, 1, f"{file} {miscounted}; all of them are read"))
    if not notes and not short:
        return findings
    of = f" of {expected}" if expected > total else ""
    why = "; it ".join(notes) or f"holds fewer messages than it should: it {miscounted}"
    message = f"{file} {why}; recovered {total}{of} messages, {collector.lasting:.1f} s"
    severity = "error" if total < _WHOLE * expected else "warning"
    return [*findings, Finding(severity, file, "", "", total, max(1, len(notes)), message)]


def _odd_nanosec_findings(file: str, namespace: str, rows: dict[str, Rows]) -> list[Finding]:
    """A warning for each topic of which messages were left out for the nanoseconds of their stamps."""
    return [Finding("warning", file, topic, "header.stamp", row.first_nanosec, row.odd_stamps, (
                f"{file}: {topic}: {nanosec_words(row.first_nanosec)}; {row.odd_stamps} messages are so and are left out"))
            for topic, row in rows.items() if row.odd_stamps and _within(topic, namespace)]


def _unreadable_findings(file: str, namespace: str, rows: dict[str, Rows]) -> list[Finding]:
    findings = []
    for topic, row in rows.items():
        if row.unreadable and _within(topic, namespace):
            message = (
                f"{file}: {row.unreadable} messages on {topic} cannot be decoded and are left out, "
                f"the first has {row.shortest} bytes"
            )
            findings.append(Finding("warning", file, topic, "", row.shortest, row.unreadable, message))
    return findings


def _missing_findings(file: str, namespace: str, streams: dict[str, Stream], collector: Collector) -> list[Finding]:
    findings = []
    consequences = {
        DRIVE_TOPIC: "the motor's losses and the shaft's speed are not known",
        HYDRAULIC_TOPIC: "pressures and rod motion are not known",
        TEMPERATURE_PREFIX + "ambient": "the ambient temperature must be assumed",
    }
    for relative, consequence in consequences.items():
        if relative in streams:
            continue
        topic = f"{namespace}/{relative}"
        empty = "is left out" if collector.counts[topic] else "is announced but has no message"
        state = empty if topic in collector.types else "is missing"
        near = _similar(topic, namespace, collector)
        message = f"{file}: topic {topic} {state}, {consequence}{near}"
        findings.append(Finding("warning", file, topic, "", None, 1, message))
    return findings


def _similar(topic: str, namespace: str, collector: Collector) -> str:
    for other in sorted(collector.types):
        if not split_topic(other) and f"{namespace}/{nearest_telemetry(other, namespace)}" == topic:
            return f"; did {other} mean it?"
    return ""


def _other_topics(file: str, namespace: str, collector: Collector) -> list[Finding]:
    others = sorted(topic for topic in collector.types if not _within(topic, namespace))
    findings = []
    for topic in others:
        relative = topic[len(namespace) + 1 :] if topic.startswith(namespace + "/") else ""
        if relative.startswith(TEMPERATURE_PREFIX) and relative not in BESIDE_SENSORS:
            message = (
                f"{file}: topic {topic} is no sensor of the interface and is ignored; nearest is "
                f"{nearest_telemetry(topic, namespace)}, valid are {', '.join(TEMPERATURE_SENSORS)}"
            )
            findings.append(Finding("warning", file, topic, "", None, collector.counts[topic], message))
    elsewhere = _telemetry_elsewhere(others)
    findings += [Finding("warning", file, "", "", ", ".join(topics), len(topics), (
        f"{file}: {len(topics)} topics of telemetry are in the namespace {other or '/'!r} and not in the rig's, {namespace or '/'!r}, and "
        f"are ignored: {first_of(topics, _MOST_NAMED)}; they belong beside {namespace}/{DRIVE_TOPIC}"))
        for other, topics in elsewhere.items()]
    told = {f.topic for f in findings} | {topic for topics in elsewhere.values() for topic in topics}
    listed = [topic for topic in others if topic not in told]
    if listed:
        message = f"{file}: {len(listed)} other topics are ignored: {first_of(listed, _MOST_NAMED)}"
        findings.append(Finding("info", file, "", "", ", ".join(listed), len(listed), message))
    return findings


def _telemetry_elsewhere(others: list[str]) -> dict[str, list[str]]:
    """Topics of telemetry by their namespace, of those in which no machine is."""
    by_namespace: dict[str, list[str]] = {}
    machines = set()
    for topic in others:
        if split := split_topic(topic):
            by_namespace.setdefault(split[0], []).append(topic)
            machines |= {split[0]} if split[1] in (DRIVE_TOPIC, HYDRAULIC_TOPIC) else set()
    return {namespace: topics for namespace, topics in by_namespace.items() if namespace not in machines}


def _no_length(file: str, streams: dict[str, Stream], epoch: int) -> list[Finding]:
    """That a recording covers no time, or has one message of each topic."""
    first, last = (pick(float(pick(stream.time)) for stream in streams.values()) for pick in (min, max))
    if last > first and max(map(len, streams.values())) > 1:
        return []
    one = "covers no time: all its messages have one stamp" if epoch else f"covers no time, as {UNSTAMPED}"
    message = f"{file} {one if last <= first else 'holds one message of each topic'}, and nothing can be told of it"
    return [Finding("warning", file, "", "", 0.0, 1, message)]
