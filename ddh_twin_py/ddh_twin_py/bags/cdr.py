"""Bulk coding of CDR messages that are a header followed by float64 fields.

Layout, offsets from the start of the message: encapsulation 4 bytes (second byte 1: little
endian, 0: big endian), stamp int32 s and uint32 ns, length of frame_id uint32 with its final
zero, frame_id, padding to 8 bytes counted from offset 4, then the float64 fields.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

ENCAPSULATION = 4
_FIXED = 16  # encapsulation, stamp and the length of frame_id
MOST_NANOSEC = 999_999_999
"""Of a stamp: what is more are seconds."""


def stamped_floats(
    data: np.ndarray, start: np.ndarray, size: np.ndarray, fields: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stamps and values of many messages of one type.

    `data` uint8[...] holds the messages; message i is data[start[i]:start[i] + size[i]].
    Returns stamps int64[n] in ns, values float64[n, fields] and sound bool[n]: False where a
    message is too short or not plain CDR, or its stamp has nanoseconds of more than a second; its stamp is 0 and its values are NaN.
    """
    count = start.size
    stamps = np.zeros(count, np.int64)
    values = np.full((count, fields), np.nan)
    sound = size >= _FIXED
    if not count:
        return stamps, values, sound
    heads = np.zeros((count, _FIXED), np.uint8)
    heads[sound] = _gather(data, start[sound], _FIXED)
    sound &= (heads[:, 0] == 0) & (heads[:, 1] <= 1)
    for little in (1, 0):
        chosen = np.flatnonzero(sound & (heads[:, 1] == little))
        if not chosen.size:
            continue
        order = "<" if little else ">"
        words = np.ascontiguousarray(heads[chosen, ENCAPSULATION:]).view(f"{order}u4")
        seconds = words[:, 0].astype(np.int32).astype(np.int64)
        stamps[chosen] = seconds * 1_000_000_000 + words[:, 1]
        frame = words[:, 2].astype(np.int64)
        offset = ENCAPSULATION + (_FIXED - ENCAPSULATION + frame + 7) // 8 * 8
        whole = (offset + 8 * fields <= size[chosen]) & (words[:, 1] <= MOST_NANOSEC)
        sound[chosen[~whole]] = False
        stamps[chosen[~whole]] = 0
        rows = _gather(data, start[chosen[whole]] + offset[whole], 8 * fields)
        values[chosen[whole]] = rows.view(f"{order}f8")
    return stamps, values, sound


def floats_of_messages(messages: Sequence[bytes], fields: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same of messages that lie each for itself."""
    return stamped_floats(*_one_after_another(messages), fields)


def _one_after_another(messages: Sequence[bytes]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Such messages as `data`, `start` and `size` of `stamped_floats`."""
    size = np.array([len(message) for message in messages], np.int64)
    return np.frombuffer(b"".join(messages), np.uint8), np.cumsum(size) - size, size


def odd_nanosec(data: np.ndarray, start: np.ndarray, size: np.ndarray) -> np.ndarray:
    """The nanoseconds of messages, see `stamped_floats`, whose stamp has those of more than a second, int64[k]."""
    heads = _gather(data, start[size >= _FIXED], _FIXED)
    nanosec = np.ascontiguousarray(heads[:, ENCAPSULATION + 4 : ENCAPSULATION + 8])
    told = np.where(heads[:, 1] == 1, nanosec.view("<u4")[:, 0], nanosec.view(">u4")[:, 0]).astype(np.int64)
    return told[(heads[:, 0] == 0) & (heads[:, 1] <= 1) & (told > MOST_NANOSEC)]


def first_odd_nanosec(messages: Sequence[bytes]) -> int:
    """The first of them, of messages that lie each for itself; 0 where there is none."""
    return int([*odd_nanosec(*_one_after_another(messages)), 0][0])


def nanosec_words(nanosec: int) -> str:
    """What is wrong with a stamp that has so many."""
    return f"header.stamp nanosec is {nanosec}, allowed are 0 to {MOST_NANOSEC}"


def encode_stamped_floats(stamps: np.ndarray, values: np.ndarray, frame_id: str = "") -> np.ndarray:
    """Messages as rows of uint8[n, size], little endian: stamps int64[n] ns, values float64[n, m]."""
    frame = frame_id.encode() + b"\0"
    offset = ENCAPSULATION + (_FIXED - ENCAPSULATION + len(frame) + 7) // 8 * 8
    messages = np.zeros((stamps.size, offset + 8 * values.shape[1]), np.uint8)
    messages[:, 1] = 1
    words = np.empty((stamps.size, 3), "<u4")
    words[:, 0] = (stamps // 1_000_000_000).astype("<i4").view("<u4")
    words[:, 1] = stamps % 1_000_000_000
    words[:, 2] = len(frame)
    messages[:, ENCAPSULATION:_FIXED] = words.view(np.uint8)
    messages[:, _FIXED : _FIXED + len(frame)] = np.frombuffer(frame, np.uint8)
    messages[:, offset:] = np.ascontiguousarray(values, "<f8").view(np.uint8)
    return messages


def _gather(data: np.ndarray, start: np.ndarray, width: int) -> np.ndarray:
    """Rows data[start[i]:start[i] + width] as uint8[n, width]."""
    if not start.size:
        return np.empty((0, width), np.uint8)
    return np.lib.stride_tricks.sliding_window_view(data, width)[start]
