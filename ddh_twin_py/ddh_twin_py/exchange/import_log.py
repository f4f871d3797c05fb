"""CSV logs of a machine as a recording by the interface's contract."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.exchange.log_file import LogFile, read_log
from ddh_twin_py.exchange.mapping import ColumnRule, LogMapping
from ddh_twin_py.names import no_such
from ddh_twin_py.telemetry.recording import Recording, Stream, temperature_stream
from ddh_twin_py.telemetry.signals import MACHINE_FIELDS, TEMPERATURE_PREFIX

_EARLY = 1.0e-9  # s by which a reading may come before its time


def import_logs(paths: Sequence[str | Path], mapping: LogMapping) -> Recording:
    """Read logs of one machine, such as one with drive and pressures and another with temperatures, or parts that follow each other.

    A signal is taken from every log that has its column; logs that follow each other are put in order of time, however they are given.
    A line in which a stream has no value at all gives no sample; one that has some gives NaN for the others. Temperatures are thinned to
    one reading in `every_s`.

    Raises:
        ExchangeError: naming file, line and column where a log cannot be read or a column of the mapping is in none of them; naming
            two logs that tell of one topic at the same time.
    """
    wanted = [mapping.time.column, *(rule.column for rule in mapping.columns)]
    logs = [read_log(path, mapping.dialect, wanted) for path in paths]
    _all_there(logs, mapping)
    parts: dict[str, list[_Part]] = {}
    for log in logs:
        stamps = log.stamps(mapping.time)
        for topic, stamp, values in _samples(log, stamps, mapping):
            if stamp.size:
                parts.setdefault(topic, []).append((log.file, stamp, values))
    joined = {topic: _joined(topic, found) for topic, found in parts.items()}
    if not joined:
        raise ExchangeError(f"{paths[0]}: no line has a value in any column of {mapping.file}")
    epoch = min(int(stamp.min()) for stamp, _ in joined.values())
    streams = {topic: _stream(topic, (stamp - epoch) * 1e-9, values) for topic, (stamp, values) in joined.items()}
    return Recording(str(paths[0]), epoch, mapping.rig, None, None).with_streams(streams)


_Part = tuple[str, np.ndarray, np.ndarray]  # file, stamps int64[n] ns, values float64[n, m]


def _joined(topic: str, parts: Sequence[_Part]) -> tuple[np.ndarray, np.ndarray]:
    """Stamps and values of one topic, of logs in the order of their first stamps."""
    ordered = sorted(parts, key=lambda part: part[1][0])
    for (file, stamps, _), (next_file, next_stamps, _) in itertools.pairwise(ordered):
        if next_stamps[0] < stamps[-1]:
            both = (min(stamps[-1], next_stamps[-1]) - next_stamps[0]) * 1e-9
            raise ExchangeError(f"{next_file}: {topic} is told for {both:.3f} s by {file}, too; logs of one topic must follow each other")
    return np.concatenate([stamps for _, stamps, _ in ordered]), np.concatenate([values for *_, values in ordered])


def _all_there(logs: Sequence[LogFile], mapping: LogMapping) -> None:
    for log in logs:
        if mapping.time.column not in log.cells:
            raise ExchangeError(f"{log.file}: line {mapping.dialect.header_line}: "
                                f"{no_such('column', mapping.time.column, list(log.headings))} "
                                f"(time.column of {mapping.file}){_uncut(log)}")
    headings = list(dict.fromkeys(name for log in logs for name in log.headings))
    for rule in mapping.columns:
        if not any(rule.column in log.cells for log in logs):
            names = ", ".join(log.file for log in logs)
            raise ExchangeError(f"{names}: line {mapping.dialect.header_line}: {no_such('column', rule.column, headings)} "
                                f"(columns.{rule.signal.name} of {mapping.file}){_uncut(logs[0])}")


def _uncut(log: LogFile) -> str:
    """What is said beside of a log whose heading is one column."""
    return f"; its heading is one column, cut at {log.dialect.delimiter!r} (csv.delimiter)" if len(log.headings) == 1 else ""


def _samples(log: LogFile, stamps: np.ndarray, mapping: LogMapping):
    """Topic, stamps and values of each stream that the log has a column of."""
    rules = [rule for rule in mapping.columns if rule.column in log.cells]
    for topic, fields in MACHINE_FIELDS.items():
        own = {rule.signal.field: rule for rule in rules if rule.signal.topic == topic}
        if own:
            values = np.full((stamps.size, len(fields)), np.nan)
            for field, rule in own.items():
                values[:, fields.index(field)] = rule.inside(log.numbers(rule.column))
            there = ~np.isnan(values).all(axis=1)
            yield topic, stamps[there], values[there]
    for rule in rules:
        if rule.signal.topic.startswith(TEMPERATURE_PREFIX):
            kelvin = rule.inside(log.numbers(rule.column))
            chosen = _thinned(stamps, np.flatnonzero(~np.isnan(kelvin)), rule)
            yield rule.signal.topic, stamps[chosen], np.column_stack([kelvin[chosen], np.full(chosen.size, rule.variance)])


def _thinned(stamps: np.ndarray, rows: np.ndarray, rule: ColumnRule) -> np.ndarray:
    """Rows that come at least `every` after the one before, or before it."""
    step = round((rule.every - _EARLY) * 1e9)
    kept: list[int] = []
    last = None
    for row, stamp in zip(rows.tolist(), stamps[rows].tolist(), strict=True):
        if last is None or stamp - last >= step or stamp < last:
            kept.append(row)
            last = stamp
    return np.array(kept, np.int64)


def _stream(topic: str, time: np.ndarray, values: np.ndarray) -> Stream:
    fields = MACHINE_FIELDS.get(topic)
    return temperature_stream(time, values[:, 0], values[:, 1]) if fields is None else Stream(time, values, fields)
