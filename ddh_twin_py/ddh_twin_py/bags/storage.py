"""What every storage format hands to the reader: channels, and blocks of raw messages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ddh_twin_py.rig.files import printable

EVER = (1, 2**63 - 1)
"""The widest span of log times, ns; 0 is no time."""


_LONGEST = 255  # characters of a name that a bag tells


def told(text: object) -> str:
    """A name or a word that a bag tells as it can be shown: on one line, without control characters, of so many characters at most."""
    shown = printable(str(text)[: _LONGEST + 1])
    return shown if len(shown) <= _LONGEST else f"{shown[:_LONGEST]}... ({len(str(text))} characters)"


@dataclass(frozen=True)
class Channel:
    """One topic of one file: name, type, definition text ('' if none), its encoding, type hash; name and type as they can be shown."""

    topic: str
    message_type: str
    definition: str = ""
    definition_encoding: str = ""
    type_hash: str = ""
    serialization: str = "cdr"

    def __post_init__(self) -> None:
        for name in ("topic", "message_type"):
            object.__setattr__(self, name, told(getattr(self, name)))


@dataclass(frozen=True)
class Block:
    """Raw messages that lie in one buffer.

    `data` uint8[...]; message i is of channel `channel[i]` (a key of the storage's channels),
    was logged at `log_time[i]` ns and is data[start[i]:start[i] + size[i]].
    `position` is how far into the file the block reached, 0..1. `span`: ns from first to last log
    time as the file tells them apart from the messages; a message of another time is damaged.
    """

    data: np.ndarray
    channel: np.ndarray
    log_time: np.ndarray
    start: np.ndarray
    size: np.ndarray
    position: float
    span: tuple[int, int] = EVER


class Storage(Protocol):
    """One opened file of a bag.

    `channels`, `damage` (sentences on what could not be read) and `remarks` (on what is odd and costs no message) grow while `blocks` is
    consumed.
    """

    channels: dict[int, Channel]
    damage: list[str]
    remarks: list[str]

    def blocks(self) -> Iterator[Block]:
        """Raw messages in the order of the file."""
        ...
