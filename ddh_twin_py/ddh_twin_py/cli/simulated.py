"""The chunks of a simulated rig as one recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from ddh_twin_py.telemetry.recording import Recording, Stream


def collect(
    chunks: Iterable[Recording], epoch_ns: int, duration: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Join chunks, whose epoch is 0, into one recording that starts at ``epoch_ns``."""
    parts: dict[str, list[Stream]] = {}
    first = None
    for chunk in chunks:
        first = first or chunk
        for topic, stream in chunk.streams():
            parts.setdefault(topic, []).append(stream)
            if progress is not None and duration and stream.time.size:
                progress(min(1.0, float(stream.time[-1]) / duration))
    if first is None:
        return Recording("simulated rig", epoch_ns, None, None, None)
    joined = {
        topic: Stream(
            np.concatenate([s.time for s in streams]), np.concatenate([s.values for s in streams]), streams[0].fields
        )
        for topic, streams in parts.items()
    }
    return replace(first, epoch_ns=epoch_ns).with_streams(joined)
