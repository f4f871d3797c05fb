"""Frames of numbers as they go to the page: a short header in JSON, then float32.

Layout, little endian: length of the header uint32; header, filled up with spaces to a multiple of 4 bytes; for each block
its rows of float32, one value for each column of its stream.

Header: ``n`` number of the frame, ``t`` row of the page's clock, ``b`` blocks ``[stream, [rows before t, ...]]``.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

_LENGTH = 4


@dataclass(frozen=True)
class Block:
    """Rows of one stream: its number, row indices int64 (n,), values float32 (n, fields)."""

    stream: int
    index: np.ndarray
    values: np.ndarray


def encode(number: int, now: int, blocks: Sequence[Block]) -> bytes:
    """One frame."""
    header = {"n": number, "t": now, "b": [[block.stream, (now - block.index).tolist()] for block in blocks]}
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return b"".join([len(text).to_bytes(_LENGTH, "little"), text, *(np.ascontiguousarray(b.values, "<f4").tobytes() for b in blocks)])


def decode(frame: bytes, widths: Sequence[int]) -> tuple[int, int, list[Block]]:
    """Number, row of the clock and blocks of a frame, where stream i has `widths[i]` columns; what the page's script does too."""
    size = int.from_bytes(frame[:_LENGTH], "little")
    header = json.loads(frame[_LENGTH : _LENGTH + size])
    at, blocks = _LENGTH + size, []
    for stream, before in header["b"]:
        count = len(before) * widths[stream]
        values = np.frombuffer(frame, "<f4", count, at).reshape(len(before), widths[stream])
        blocks.append(Block(stream, header["t"] - np.array(before, np.int64), values))
        at += 4 * count
    return header["n"], header["t"], blocks
