"""What a source of telemetry is. A further one (a fieldbus, say) is one new file in this folder.

The file has a string `NAME`, by which the parameter `source` chooses it, a tuple `OPTIONS`, which
become parameters `<NAME>.<option>` of the telemetry nodes, and a function

    open_source(options: Mapping[str, object]) -> Source

that raises SourceError, one line for people, when the options cannot be used. Nothing else has
to be changed; files without `NAME` are helpers.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ddh_twin_py.telemetry.recording import RigInfo


class SourceError(ValueError):
    """A source that cannot be opened or read; the message names what was given and what is allowed."""


@dataclass(frozen=True)
class Option:
    """One thing that a source wants to know; the type is that of `default`."""

    name: str
    default: bool | int | float | str
    description: str
    unit: str = ""
    lowest: float | None = None


@dataclass(frozen=True)
class Samples:
    """Samples of one topic in the order in which they are to be published.

    `due` float64[n]: when, in s after the start of the record, never falling; `stamp` int64[n]:
    time of measurement in ns; `values` float64[n, m]: SI, temperatures in kelvin.
    """

    due: np.ndarray
    stamp: np.ndarray
    values: np.ndarray


class Source(Protocol):
    """An opened source.

    `rig`: whose telemetry it is, None where that is not known; `start_ns`: stamp of the start of
    the record, such that a sample with that stamp is due at 0 s; `duration`: s, None where it
    has no end or none is known; `seekable`: whether `batches` may be called again.
    """

    rig: RigInfo | None
    start_ns: int
    duration: float | None
    seekable: bool

    def batches(self, topics: Collection[str]) -> Iterator[Mapping[str, Samples]]:
        """Samples of the wanted topics (relative names), batch after batch in order of `due`.

        A batch holds all samples of the wanted topics in its stretch of time, at most a few
        seconds; topics that the source does not have are absent. Live sources yield what
        there is, an empty batch where there is nothing, and never block for long.
        """
        ...
