"""Make bad recordings and bad bags out of good ones: for tests, and to try out what the twin says.

Functions on recordings return a new one and leave the given one alone; `stream` is a relative
topic, times are s relative to the recording's epoch. Functions on bags change files.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ddh_twin_py.telemetry.recording import Recording, Stream


def _changed(recording: Recording, stream: str, change: Callable[[np.ndarray, np.ndarray], tuple]) -> Recording:
    streams = dict(recording.streams())
    old = streams[stream]
    time, values = change(old.time.copy(), old.values.copy())
    streams[stream] = Stream(time, values, old.fields)
    return recording.with_streams(streams)


def _set(recording: Recording, stream: str, field: str, start: float, stop: float, rule) -> Recording:
    column = dict(recording.streams())[stream].fields.index(field)

    def change(time, values):
        chosen = (time >= start) & (time < stop)
        values[chosen, column] = rule(values[chosen, column])
        return time, values

    return _changed(recording, stream, change)


def with_value(recording, stream, field, value, start=-np.inf, stop=np.inf) -> Recording:
    """A field reads `value` (NaN for a drop-out) from start to stop."""
    return _set(recording, stream, field, start, stop, lambda old: np.full_like(old, value))


def with_stuck_sensor(recording, stream, field, start, stop=np.inf) -> Recording:
    """A field keeps its value of `start` until stop."""
    return _set(recording, stream, field, start, stop, lambda old: np.full_like(old, old[0]))


def with_wrong_unit(recording, stream, field, factor, offset=0.0) -> Recording:
    """A field is given as factor * value + offset (1e-5: bar for Pa; 273.15: K for degC)."""
    return _set(recording, stream, field, -np.inf, np.inf, lambda old: factor * old + offset)


def with_repeated_stamps(recording, stream, every=10) -> Recording:
    """Each `every`-th message comes twice."""

    def change(time, values):
        twice = np.sort(np.concatenate([np.arange(time.size), np.arange(0, time.size, every)]))
        return time[twice], values[twice]

    return _changed(recording, stream, change)


def with_shuffled_arrival(recording, stream, lateness, seed=0) -> Recording:
    """Messages arrive up to `lateness` s late, hence out of order."""

    def change(time, values):
        delay = np.random.default_rng(seed).uniform(0.0, lateness, time.size)
        order = np.argsort(time + delay, kind="stable")
        return time[order], values[order]

    return _changed(recording, stream, change)


def with_clock_jump(recording, at, by) -> Recording:
    """From `at` on all stamps are moved by `by` s (negative: the clock jumps back)."""
    for stream, _ in recording.streams():
        recording = _changed(recording, stream, lambda t, v: (np.where(t >= at, t + by, t), v))
    return recording


def without_samples(recording, stream, start, stop) -> Recording:
    """The stream stops at `start` and comes back at `stop`."""

    def change(time, values):
        kept = (time < start) | (time >= stop)
        return time[kept], values[kept]

    return _changed(recording, stream, change)


def without_stream(recording, stream) -> Recording:
    """The topic is missing."""
    return recording.with_streams({name: s for name, s in recording.streams() if name != stream})


def storage_file(bag: str | Path) -> Path:
    """The one .mcap or .db3 file of a bag folder."""
    (file,) = [p for p in Path(bag).iterdir() if p.suffix in (".mcap", ".db3")]
    return file


def truncate(bag: str | Path, share: float, keep_metadata: bool = False) -> None:
    """Cut the bag's file after that share of its bytes, as a killed recorder leaves it."""
    file = storage_file(bag)
    with file.open("r+b") as opened:
        opened.truncate(int(file.stat().st_size * share))
    if not keep_metadata:
        (Path(bag) / "metadata.yaml").unlink()
