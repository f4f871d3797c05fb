"""Unpack what rosbag2 packs: chunks, messages and whole files; also halves of them."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import numpy as np
from lz4.frame import LZ4FrameDecompressor

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

CHUNK_COMPRESSIONS = ("", "zstd", "lz4")


class UnknownCompression(ValueError):
    """A compression that nobody here can undo; names it and those that are known."""


def unpack_chunk(packed: bytes, name: str, size: int, partial: bool = False) -> tuple[bytes, bool, bool]:
    """Content of a chunk of `size` bytes, whether it is whole, and whether nothing of the packed bytes was found to be damaged.

    Where the packed bytes are cut or damaged, as much as could be unpacked is returned. Neither compression tells where the damage
    began: it may have changed what was unpacked before. Raises UnknownCompression.
    """
    sound = True
    if name == "":
        raw = packed
    elif name == "zstd" and not partial:
        try:
            raw = zstd.decompress(packed)
        except zstd.ZstdError:
            raw, sound = _piecewise(zstd.ZstdDecompressor(), packed, zstd.ZstdError)
    elif name == "zstd":
        raw, sound = _piecewise(zstd.ZstdDecompressor(), packed, zstd.ZstdError)
    elif name == "lz4":
        raw, sound = _piecewise(LZ4FrameDecompressor(), packed, RuntimeError)
    else:
        known = ", ".join(repr(c) for c in CHUNK_COMPRESSIONS)
        raise UnknownCompression(f"compression {name!r} cannot be read; known are {known}")
    return raw, len(raw) == size, sound


def pack_chunk(raw: bytes) -> bytes:
    """A chunk packed by zstd, with a checksum, so that flipped bits are noticed."""
    return zstd.compress(raw, options={zstd.CompressionParameter.checksum_flag: 1})


def _piecewise(decompressor, packed: bytes, errors, step: int = 1 << 14) -> tuple[bytes, bool]:
    """What could be unpacked, and whether it ended for want of bytes and not by an error."""
    parts, sound = [], True
    try:
        for at in range(0, len(packed), step):
            if decompressor.eof:
                break
            parts.append(decompressor.decompress(packed[at : at + step]))
    except (errors, EOFError):
        sound = False
    return b"".join(parts), sound


def unpack_messages(data: np.ndarray, start: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Data, start and size of messages of a bag with `compression_mode: message`, zstd; a damaged one becomes 0 bytes long.

    Message i is data[start[i]:start[i] + size[i]], data uint8[...], start and size int64[n].
    """
    messages = []
    for begin, length in zip(start.tolist(), size.tolist(), strict=True):
        try:
            messages.append(zstd.decompress(data[begin : begin + length].tobytes()))
        except zstd.ZstdError:
            messages.append(b"")
    sizes = np.array([len(m) for m in messages], np.int64)
    return np.frombuffer(b"".join(messages), np.uint8), np.cumsum(sizes) - sizes, sizes


def unpack_file(packed: Path, target: Path) -> None:
    """A file of a bag with `compression_mode: file`, zstd. Raises ValueError when damaged."""
    try:
        with zstd.open(packed, "rb") as source, target.open("wb") as sink:
            shutil.copyfileobj(source, sink, 1 << 14)  # of a file that is cut, less than this is lost
    except (zstd.ZstdError, EOFError) as error:
        raise ValueError(str(error)) from None
