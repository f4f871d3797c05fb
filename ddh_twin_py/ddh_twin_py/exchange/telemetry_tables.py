"""The telemetry of a recording as it was measured: a CSV file for each stream, and the mapping that imports them again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import yaml

from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.rig.files import printable, whole_folder, write_whole
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX, signals_of

MAPPING = "mapping.yaml"
_STAMP = "stamp [ns]"


def write_telemetry(folder: str | Path, recording: Recording) -> list[Path]:
    """Write `drive_telemetry.csv`, `hydraulics_telemetry.csv`, `temperature_<sensor>.csv` and `mapping.yaml`; returns their paths.

    The folder must not exist; it is written whole or not at all.
    Every number has all its digits, in the unit of the message. A variance that changes from reading to reading is left out.
    Raises ExchangeError where there is no sample, OSError where the disk can take no more.
    """
    with whole_folder(folder) as made:
        written = _write(made, recording)
    return [Path(folder) / path.name for path in written]


def _write(folder: Path, recording: Recording) -> list[Path]:
    written, columns = [], {}
    for topic, stream in recording.streams():
        if not len(stream):
            continue
        signals = signals_of(topic)
        headings = [f"{signal.name} [{signal.message_unit}]" for signal in signals]
        values = [signal.to_message(stream.values[:, i]).tolist() for i, signal in enumerate(signals)]
        rows = zip(stream.stamps(recording.epoch_ns).tolist(), *values, strict=True)
        lines = "".join(f"{','.join(map(repr, row))}\n" for row in rows).replace("nan", "")
        written.append(write_whole(folder / f"{topic.replace('/', '_')}.csv", ",".join([_STAMP, *headings]) + "\n" + lines))
        for signal, heading in zip(signals, headings, strict=True):
            columns[signal.name] = {"column": heading, "unit": signal.message_unit}
        if topic.startswith(TEMPERATURE_PREFIX):
            columns[topic]["every_s"] = 0.0
            variance = np.unique(stream.column("variance"))
            if variance.size == 1 and variance[0] > 0.0:
                columns[topic]["variance_K2"] = float(variance[0])
    if not written:
        raise ExchangeError(f"{recording.path}: no sample to write")
    mapping = {"time": {"column": _STAMP, "unit": "ns"}, "columns": columns}
    if recording.rig is not None:
        mapping["rig"] = {"rig_id": recording.rig.rig_id, "oil_grade": recording.rig.oil_grade}
        if np.isfinite(recording.rig.payload_mass):
            mapping["rig"]["payload_mass_kg"] = float(recording.rig.payload_mass)
    names = " ".join(path.name for path in written)
    heading = f"# Written by ddh-twin export from {printable(recording.path)}.\n# ddh-twin import {names} --mapping {MAPPING} -o BAG\n"
    written.append(write_whole(folder / MAPPING, heading + yaml.safe_dump(mapping, sort_keys=False, allow_unicode=True)))
    return written
