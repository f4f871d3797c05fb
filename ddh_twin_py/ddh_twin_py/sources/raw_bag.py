"""The messages of a bag as they were recorded, in order, for playing back."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.bags.compression import unpack_file, unpack_message
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.folder import open_folder
from ddh_twin_py.bags.mcap_storage import McapStorage
from ddh_twin_py.bags.sqlite_storage import SqliteStorage
from ddh_twin_py.bags.storage import Storage


@dataclass(frozen=True)
class RawBlock:
    """Serialised messages in order of log time.

    `topic[i]` numbers the topic in the bag's `topics`; `log_time` int64[n] ns; `messages` as CDR.
    """

    topic: np.ndarray
    log_time: np.ndarray
    messages: list[bytes]


class RawBag:
    """A bag opened for playing.

    `topics` lists (name, type) and is complete from the start; `first_ns` and `last_ns` are the
    log times at both ends, `count` the number of messages, `notes` what could not be read.
    Raises BagError when there is no bag, or nothing in it.
    """

    def __init__(self, path: str | Path) -> None:
        self._folder = open_folder(path)
        self._scratch = tempfile.TemporaryDirectory(prefix="ddh_bag_")
        self.path = str(self._folder.path)
        self._files = [self._unpacked(file) for file in self._folder.files]
        self.topics: list[tuple[str, str]] = []
        self._number: dict[tuple[str, str], int] = {}
        self.notes: list[str] = list(self._folder.notes)
        self.count, self.first_ns, self.last_ns = 0, 2**63 - 1, -(2**63)
        for block in self._blocks(self.notes):
            self.count += block[1].size
            if block[1].size:
                self.first_ns = min(self.first_ns, int(block[1].min()))
                self.last_ns = max(self.last_ns, int(block[1].max()))
        if not self.count:
            raise BagError(f"{self.path} holds no messages" + (f": it {self.notes[0]}" if self.notes else ""))

    @property
    def duration(self) -> float:
        """From the first to the last message, s of log time."""
        return (self.last_ns - self.first_ns) * 1e-9

    def blocks(self, start_ns: int | None = None) -> Iterator[RawBlock]:
        """Messages logged at `start_ns` or later, block by block."""
        packed = self._folder.compression_mode == "message"
        for topic, log_time, start, size, data in self._blocks([]):
            order = np.argsort(log_time, kind="stable")
            if start_ns is not None:
                order = order[log_time[order] >= start_ns]
            if not order.size:
                continue
            content = data.tobytes()
            messages = [content[a : a + n] for a, n in zip(start[order].tolist(), size[order].tolist(), strict=True)]
            if packed:
                messages = [unpack_message(message) for message in messages]
            yield RawBlock(topic[order], log_time[order], messages)

    def close(self) -> None:
        """Remove what was unpacked."""
        self._scratch.cleanup()

    def _blocks(self, notes: list[str]) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        for file in self._files:
            storage = self._open(file)
            for block in storage.blocks():
                known = np.isin(block.channel, list(storage.channels))
                topic = np.zeros(block.channel.size, np.int64)
                for key in np.unique(block.channel[known]):
                    channel = storage.channels[int(key)]
                    topic[block.channel == key] = self._number_of((channel.topic, channel.message_type))
                yield topic[known], block.log_time[known], block.start[known], block.size[known], block.data
            notes += storage.damage

    def _number_of(self, topic: tuple[str, str]) -> int:
        if topic not in self._number:
            self._number[topic] = len(self.topics)
            self.topics.append(topic)
        return self._number[topic]

    def _open(self, file: Path) -> Storage:
        return McapStorage(file) if file.suffix == ".mcap" else SqliteStorage(file)

    def _unpacked(self, file: Path) -> Path:
        if file.suffix != ".zstd":
            return file
        target = Path(self._scratch.name) / file.stem
        try:
            unpack_file(file, target)
        except ValueError as error:
            raise BagError(f"{file} cannot be unpacked: {error}") from None
        return target
