"""What every storage format hands to the reader: channels, and blocks of raw messages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np


@dataclass(frozen=True)
class Channel:
    """One topic of one file: name, type, definition text ('' if none), its encoding, type hash."""

    topic: str
    message_type: str
    definition: str = ""
    definition_encoding: str = ""
    type_hash: str = ""
    serialization: str = "cdr"


@dataclass(frozen=True)
class Block:
    """Raw messages that lie in one buffer.

    `data` uint8[...]; message i is of channel `channel[i]` (a key of the storage's channels),
    was logged at `log_time[i]` ns and is data[start[i]:start[i] + size[i]].
    `position` is how far into the file the block reached, 0..1.
    """

    data: np.ndarray
    channel: np.ndarray
    log_time: np.ndarray
    start: np.ndarray
    size: np.ndarray
    position: float


class Storage(Protocol):
    """One opened file of a bag.

    `channels` and `damage`, sentences on what could not be read, grow while `blocks` is consumed.
    """

    channels: dict[int, Channel]
    damage: list[str]

    def blocks(self) -> Iterator[Block]:
        """Raw messages in the order of the file."""
        ...
