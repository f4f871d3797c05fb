"""What was heard in a ROS 2 graph over a while, without anything of ROS in it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class HeardTopic:
    """One topic.

    `topic` absolute; `types` of it in the graph; `publishers` their nodes, absolute names; `best_effort` and `latched` as they
    offer. `arrived` int64[n]: system clock in ns at which each message came; `messages` as CDR, oldest first.
    """

    topic: str
    types: tuple[str, ...]
    publishers: tuple[str, ...]
    best_effort: bool
    latched: bool
    arrived: np.ndarray
    messages: list[bytes]


@dataclass(frozen=True)
class Health:
    """A status of `/diagnostics`: `level` 0 well, 1 warning, 2 error, 3 stale."""

    name: str
    level: int
    message: str


@dataclass(frozen=True)
class Survey:
    """A graph, listened to for `seconds`.

    `nodes`: absolute names. `topics`: those with telemetry or of the twin, by absolute name. `other_topics`: all others.
    `health`: the last status of each name. `clock_published`: somebody publishes `/clock`.
    `loop`: s from the start of a process of our own to its first message here, None where none came.
    """

    seconds: float
    domain: int
    middleware: str
    nodes: tuple[str, ...]
    topics: dict[str, HeardTopic]
    other_topics: tuple[str, ...]
    health: tuple[Health, ...]
    clock_published: bool
    loop: float | None
    environment: dict[str, str] = field(default_factory=dict)
