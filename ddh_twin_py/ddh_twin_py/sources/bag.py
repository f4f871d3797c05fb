"""Source: the telemetry of a bag."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.sources.protocol import Option, Samples, SourceError
from ddh_twin_py.telemetry.clocks.clock import clock_segments
from ddh_twin_py.telemetry.recording import Recording
from ddh_twin_py.telemetry.ticks import REORDER_WINDOW, to_ns

NAME = "bag"
OPTIONS = (
    Option("path", "", "Bag to take telemetry from: a rosbag2 folder, or one .mcap or .db3 file."),
    Option("namespace", "", "Namespace of the rig in the bag; needed where a bag holds more than one rig."),
)

_BATCH = 1.0  # s


class BagSource:
    """A recording, in the order in which its messages arrived."""

    seekable = True

    def __init__(self, recording: Recording) -> None:
        self.rig = recording.rig
        self.notes = [str(finding) for finding in recording.warnings]
        stamps = {topic: stream.stamps(recording.epoch_ns) for topic, stream in recording.streams()}
        due = _due(stamps)
        self.start_ns = recording.epoch_ns
        self._samples = {
            topic: Samples(due[topic], stamps[topic], stream.values) for topic, stream in recording.streams()
        }
        self.duration = max(float(samples.due[-1]) for samples in self._samples.values() if samples.due.size)

    def batches(self, topics: Collection[str]) -> Iterator[Mapping[str, Samples]]:
        chosen = {topic: samples for topic, samples in self._samples.items() if topic in topics}
        for start in np.arange(0.0, self.duration + 1e-9, _BATCH):
            batch = {}
            for topic, s in chosen.items():
                first, last = np.searchsorted(s.due, (start, start + _BATCH))
                batch[topic] = Samples(s.due[first:last], s.stamp[first:last], s.values[first:last])
            yield batch


def _due(stamps: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """When each sample is due, s: its stamp, but late ones with the newest before them.

    Where the clock jumped back, the stretch behind the jump follows the one before it.
    """
    segments = clock_segments(stamps, to_ns(REORDER_WINDOW))
    count = 1 + max((int(s[-1]) for s in segments.values() if s.size), default=0)
    due = {topic: np.empty(stamp.size) for topic, stamp in stamps.items()}
    offset = 0
    for segment in range(count):
        parts = {topic: np.flatnonzero(segments[topic] == segment) for topic in stamps}
        inside = [stamps[topic][part] for topic, part in parts.items() if part.size]
        if not inside:
            continue
        start, stop = min(int(s.min()) for s in inside), max(int(s.max()) for s in inside)
        for topic, part in parts.items():
            due[topic][part] = (np.maximum.accumulate(stamps[topic][part]) - start + offset) * 1e-9
        offset += stop - start
    return {topic: np.maximum.accumulate(times) for topic, times in due.items()}


def open_source(options: Mapping[str, object]) -> BagSource:
    """Read the bag. Raises SourceError."""
    if not options.get("path"):
        raise SourceError("bag.path is empty; it names the bag to take telemetry from")
    try:
        return BagSource(read_recording(str(options["path"]), str(options.get("namespace") or "") or None))
    except BagError as error:
        raise SourceError(str(error)) from None
