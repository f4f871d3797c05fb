"""Read MCAP files from front to back, chunk by chunk, as far as they are readable.

The index at the end is not needed, so a file whose recorder was killed reads like any other:
each record is `opcode uint8, length uint64, content`; a chunk's content is records again,
compressed. Source: MCAP format specification, https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ddh_twin_py.bags.compression import UnknownCompression, unpack_chunk
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.storage import EVER, Block, Channel
from ddh_twin_py.physics.compiled import kernel

MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, DATA_END = 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x0F
_LAST_KNOWN, _FIRST_PRIVATE = 0x0F, 0x80
_RECORD_HEAD = 9
CHUNK_CRC = _RECORD_HEAD + 24
"""Bytes from the begin of a chunk's record to the CRC-32 of its unpacked records, uint32; 0 says that there is none."""
_MESSAGE_HEAD = 22
_FOOTER = _RECORD_HEAD + 20 + len(MAGIC)  # bytes of a whole file's end, which tells where its summary begins
_INDEX_HEAD, _INDEXED = 6, 16  # bytes of a message index and of its entry for one message
_LOOSE_BLOCK = 4 << 20  # bytes of messages outside chunks that are handed on at once


class McapStorage:
    """One MCAP file, opened. Raises BagError when it is no MCAP file or not of ROS 2."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.channels: dict[int, Channel] = {}
        self.damage: list[str] = []
        self.remarks: list[str] = []
        self._schemas: dict[int, tuple[str, str, str]] = {}
        with path.open("rb") as file:
            magic = file.read(len(MAGIC))
        if not magic:
            raise BagError(f"{path} is empty: 0 bytes, an MCAP file has at least 8")
        if magic != MAGIC:
            raise BagError(f"{path} is no MCAP file: its first bytes are {magic.hex(' ')}")

    def blocks(self) -> Iterator[Block]:
        """Raw messages, one block per chunk; what cannot be read is told in `damage`, an end that is cut off behind them in `remarks`."""
        total = self.path.stat().st_size
        with self.path.open("rb") as file:
            file.seek(len(MAGIC))
            yield from self._records(file, total)

    def _records(self, file: BinaryIO, total: int) -> Iterator[Block]:
        loose: list[bytes] = []  # messages outside chunks
        loose_bytes = 0
        ended = False
        while True:
            at = file.tell()
            head = file.read(_RECORD_HEAD)
            if len(head) < _RECORD_HEAD:
                self._cut(at, total, ended)
                break
            opcode, length = struct.unpack("<BQ", head)
            if opcode == 0 or _LAST_KNOWN < opcode < _FIRST_PRIVATE:
                self._cut(at, total, ended)
                break
            if opcode in (DATA_END, FOOTER):
                ended = True
                self._look_at_end(file)
                break
            available = min(length, total - file.tell())
            if opcode == CHUNK:
                content = file.read(available)
                yield from self._chunk(content, length, at, file)
            elif opcode in (SCHEMA, CHANNEL, MESSAGE) and available == length:
                content = file.read(length)
                if opcode == MESSAGE:
                    loose += (head, content)
                    loose_bytes += _RECORD_HEAD + length
                    if loose_bytes > _LOOSE_BLOCK:
                        yield self._block(b"".join(loose), file.tell() / total)
                        loose, loose_bytes = [], 0
                else:
                    self._define(opcode, content)
            else:
                file.seek(available, 1)
            if available < length:
                self._cut(at, total, ended)
                break
        if loose:
            yield self._block(b"".join(loose), 1.0)

    def _look_at_end(self, file: BinaryIO) -> None:
        file.seek(-len(MAGIC), 2)
        if file.read() != MAGIC:
            self.remarks.append("has lost its end, which holds the index: all messages lie before it and are read, but other programs may "
                                "refuse the file")

    def _cut(self, at: int, total: int, ended: bool) -> None:
        if not ended:
            beyond = ", and read beyond as far as its messages are whole" if at < total else ""
            self.damage.append(f"has no end, the recorder was stopped hard: it is whole up to byte {at} of {total}{beyond}")

    def _chunk(self, content: bytes, length: int, at: int, file: BinaryIO) -> Iterator[Block]:
        """The messages of a chunk that is sound, or is cut off by the end of the file; of a damaged one none, as any may be wrong."""
        if len(content) < 40:
            return
        position = file.tell() / self.path.stat().st_size
        *told, size, crc = struct.unpack_from("<QQQI", content)
        (name_length,) = struct.unpack_from("<I", content, 28)
        name = content[32 : 32 + name_length].decode("ascii", "replace")
        packed = content[40 + name_length :]
        try:
            raw, whole, sound = unpack_chunk(packed, name, size, partial=len(content) < length)
        except UnknownCompression as error:
            raise BagError(f"{self.path}: chunk at byte {at}: {error}") from None
        checked = bool(crc) and zlib.crc32(raw) == crc
        cut = len(content) < length and not whole and sound  # the recorder was stopped: what is there is as it was written
        why = ""
        if not whole and not cut and not checked:
            why = f"{len(raw)} of {size} bytes could be unpacked"
        elif whole and (not sound or (crc and not checked)):
            why = f"its {size} bytes do not fit its checksum"
        if why:
            lost = self._indexed(file)
            behind = f", {lost} messages by its index," if lost else ""
            self.damage.append(f"has a damaged chunk at byte {at} ({length} bytes): {why}; all of it{behind} is left out")
            self._define_lost(raw, file)
            return
        yield self._block(raw, position, EVER if checked or not told[1] else (told[0], told[1]))

    @staticmethod
    def _indexed(file: BinaryIO) -> int:
        """Messages that the indexes behind a chunk list, where the file stands; it stays there. 0 where there are none."""
        begin, count = file.tell(), 0
        while len(head := file.read(_RECORD_HEAD)) == _RECORD_HEAD:
            opcode, length = struct.unpack("<BQ", head)
            if opcode != MESSAGE_INDEX or length < _INDEX_HEAD:
                break
            count += (length - _INDEX_HEAD) // _INDEXED
            file.seek(length, 1)
        file.seek(begin)
        return count

    def _define_lost(self, raw: bytes, file: BinaryIO) -> None:
        """Definitions that a damaged chunk held: from the summary at the file's end; where that has none, from what could be unpacked."""
        schemas, channels, begin = dict(self._schemas), dict(self.channels), file.tell()
        self._block(raw, 0.0)
        self._schemas |= schemas
        self.channels |= channels
        end = file.seek(-min(_FOOTER, file.seek(0, 2)), 2)
        tail = file.read(_FOOTER)
        at = struct.unpack_from("<Q", tail, _RECORD_HEAD)[0] if len(tail) == _FOOTER and tail[0] == FOOTER and tail.endswith(MAGIC) else 0
        if 0 < at < end:
            file.seek(at)
            self._block(file.read(end - at), 0.0)
        file.seek(begin)

    def _block(self, raw: bytes, position: float, span: tuple[int, int] = EVER) -> Block:
        data = np.frombuffer(raw, np.uint8)
        most = data.size // (_RECORD_HEAD + _MESSAGE_HEAD) + 1
        channel = np.empty(most, np.int64)
        log_time = np.empty(most, np.int64)
        start = np.empty(most, np.int64)
        size = np.empty(most, np.int64)
        others = np.empty((data.size // 64 + 16, 3), np.int64)
        count, other = _walk(data, channel, log_time, start, size, others)
        for opcode, begin, length in others[:other]:
            self._define(int(opcode), raw[begin : begin + length])
        return Block(data, channel[:count], log_time[:count], start[:count], size[:count], position, span)

    def _define(self, opcode: int, content: bytes) -> None:
        try:
            if opcode == SCHEMA:
                (key,) = struct.unpack_from("<H", content, 0)
                name, at = _string(content, 2)
                encoding, at = _string(content, at)
                text, _ = _string(content, at)
                self._schemas[key] = (name, encoding, text)
            elif opcode == CHANNEL:
                key, schema = struct.unpack_from("<HH", content, 0)
                topic, at = _string(content, 4)
                serialization, _ = _string(content, at)
                name, encoding, text = self._schemas.get(schema, ("", "", ""))
                self.channels[key] = Channel(topic, name, text, encoding, "", serialization)
        except struct.error:
            self.damage.append(f"has a damaged definition record (opcode {opcode})")


def _string(content: bytes, at: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<I", content, at)
    end = at + 4 + length
    return content[at + 4 : end].decode("utf8", "replace"), end


@kernel
def _number(data, at, width):  # pragma: no cover - compiled
    """Little endian unsigned integer of `width` bytes."""
    value = np.int64(0)
    for i in range(width):
        value |= np.int64(data[at + i]) << (8 * i)
    return value


@kernel
def _walk(data, channel, log_time, start, size, others):  # pragma: no cover - compiled
    """List the messages of a run of records, and the schema and channel records among them.

    Stops at the first record that does not fit. Returns the numbers of messages and others.
    """
    at = 0
    count = 0
    other = 0
    while at + 9 <= data.size:
        opcode = data[at]
        length = _number(data, at + 1, 8)
        at += 9
        if length < 0 or length > data.size - at:
            break
        if opcode == 5 and length >= 22:
            channel[count] = _number(data, at, 2)
            log_time[count] = _number(data, at + 6, 8)
            start[count] = at + 22
            size[count] = length - 22
            count += 1
        elif (opcode == 3 or opcode == 4) and other < others.shape[0]:
            others[other, 0] = opcode
            others[other, 1] = at
            others[other, 2] = length
            other += 1
        at += length
    return count, other
