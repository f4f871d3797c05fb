"""The messages of a bag as they were recorded, in order, for playing back."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ddh_twin_py.bags.arrival import goes_on, order_of_arrival, steps_of_arrival, time_gone_by
from ddh_twin_py.bags.compression import unpack_messages
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.folder import open_folder
from ddh_twin_py.bags.opening import of_file, open_storage, readable, unpacked


@dataclass(frozen=True)
class RawBlock:
    """Serialised messages in order of log time, later than those of the block before unless the recorder's clock was set back between them.

    `topic[i]` numbers the topic in the bag's `topics`; `log_time` int64[n] ns; `due` int64[n] ns is the same, but never falls over the
    whole bag, nor leaves out more than `LONGEST_GAP` (`time_gone_by`); `messages` as CDR.
    """

    topic: np.ndarray
    log_time: np.ndarray
    due: np.ndarray
    messages: list[bytes]

    def part(self, rows: slice) -> RawBlock:
        """Some of the messages."""
        return RawBlock(self.topic[rows], self.log_time[rows], self.due[rows], self.messages[rows])


class RawBag:
    """A bag opened for playing.

    `topics` lists (name, type) and is complete from the start; `first_ns` and `last_ns` are the first and the last log time, `begin_ns` and
    `end_ns` when the first and the last message are due, `count` the number of messages, `notes` what could not be read, is not as its
    metadata.yaml says, or is odd and costs no message.
    Raises BagError when there is no bag, or nothing in it.
    """

    def __init__(self, path: str | Path) -> None:
        with readable(path):
            self._open(path)

    def _open(self, path: str | Path) -> None:
        self._folder = open_folder(path)
        self._scratch = tempfile.TemporaryDirectory(prefix="ddh_bag_")
        self.path = str(self._folder.path)
        self._files = [unpacked(file, Path(self._scratch.name)) for file in self._folder.files]
        self.topics: list[tuple[str, str]] = []
        self._number: dict[tuple[str, str], int] = {}
        self.notes: list[str] = list(self._folder.notes)
        self.count, self.first_ns, self.last_ns = 0, 2**63 - 1, -(2**63)
        ordered = True
        counts: Counter[str] = Counter()
        for topic, log_time, *_ in self._blocks(self.notes, self._folder.remarks):
            if log_time.size:
                counts.update({self.topics[number][0]: int(n) for number, n in enumerate(np.bincount(topic)) if n})
                ordered = ordered and goes_on(log_time, self.last_ns if self.count else int(log_time[0]))
                self.count += log_time.size
                self.first_ns = min(self.first_ns, int(log_time.min()))
                self.last_ns = max(self.last_ns, int(log_time.max()))
        lost = bool(self.notes)
        self.notes += self._folder.remarks
        if not lost:
            self.notes += self._folder.contradicted(dict(self.topics), self.first_ns, self.last_ns) if self.count else []
            self.notes += filter(None, [self._folder.miscounted(counts)])
        self.begin_ns, self.end_ns = self.first_ns, self.last_ns
        self._place, self._due = (None, None) if ordered else self._places()
        if not self.count:
            raise BagError(f"{self.path} holds no messages" + (f": it {self.notes[0]}" if self.notes else ""))

    @property
    def duration(self) -> float:
        """From the first to the last message, s of the time in which they are due."""
        return (self.end_ns - self.begin_ns) * 1e-9

    def blocks(self, start_ns: int | None = None) -> Iterator[RawBlock]:
        """Messages due at `start_ns` or later, in order of arrival, block by block; what stands too early in a file waits in memory."""
        begin = self.begin_ns if start_ns is None else start_ns
        stored = ((*block[:2], block[1], block[2]) for block in self._stored(begin)) if self._place is None else self._sorted()
        for topic, log_time, due, messages in stored:
            block = RawBlock(topic, log_time, due, messages).part(slice(int(np.searchsorted(due, begin)), None))
            if block.messages:
                yield block

    def close(self) -> None:
        """Remove what was unpacked."""
        self._scratch.cleanup()

    def _blocks(self, notes: list[str], remarks: list[str]) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        packed = self._folder.compression_mode == "message"
        damaged: Counter[str] = Counter()
        for file in self._files:
            storage = open_storage(file)
            for block in storage.blocks():
                known = np.isin(block.channel, list(storage.channels))
                topic = np.zeros(block.channel.size, np.int64)
                for key in np.unique(block.channel[known]):
                    channel = storage.channels[int(key)]
                    topic[block.channel == key] = self._number_of((channel.topic, channel.message_type))
                data, start, size = block.data, block.start, block.size
                if packed:
                    data, start, size = unpack_messages(data, start, size)
                    damaged.update(self.topics[number][0] for number in topic[known & (size == 0)].tolist())
                    known &= size > 0
                yield topic[known], block.log_time[known], start[known], size[known], data
            notes += of_file(storage.damage, file, self._files)
            remarks += of_file(storage.remarks, file, self._files)
        notes += [f"holds {count} messages on {topic} that cannot be unpacked and are left out" for topic, count in damaged.items()]

    def _places(self) -> tuple[np.ndarray, np.ndarray]:
        """Which place in order of arrival each message has, int64[n], in the order of the files; when the one of each place is due, ns."""
        topic, log_time = (np.concatenate(parts) for parts in zip(*(block[:2] for block in self._blocks([], [])), strict=True))
        times, back = steps_of_arrival(log_time, topic)
        order = order_of_arrival(times, back)
        place = np.empty_like(order)
        place[order] = np.arange(order.size)
        due, left_out = time_gone_by(times[order])
        self.begin_ns, self.end_ns = int(due[0]), int(due[-1])
        if left_out:
            (at, length), more = left_out[0], len(left_out) - 1
            and_so = f", and so {more} more time{'s' * (more > 1)}" * (more > 0)
            self.notes.append(f"holds nothing for {length * 1e-9:.0f} s at {(at - self.begin_ns) * 1e-9:.1f} s{and_so}: the recorder's "
                              "clock was set ahead, or nothing was recorded; that is not waited for")
        return place, due

    def _stored(self, begin: int) -> Iterator[tuple[np.ndarray, np.ndarray, list[bytes]]]:
        """Topic, log time and CDR of the messages as they stand in the files, without blocks that end before ``begin``, ns."""
        for topic, log_time, start, size, data in self._blocks([], []):
            if not log_time.size or log_time[-1] < begin:
                continue
            content = data.tobytes()
            yield topic, log_time, [content[a : a + n] for a, n in zip(start.tolist(), size.tolist(), strict=True)]

    def _sorted(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, list[bytes]]]:
        """Topic, log time, when due and CDR in order of arrival; where the log time steps back a block ends."""
        least = np.append(np.minimum.accumulate(self._place[::-1])[::-1], self.count)  # of all places from a message on
        held: dict[int, tuple[int, int, bytes]] = {}
        read = done = 0
        for block in self._stored(-(2**63)):
            held.update(zip(self._place[read : read + block[1].size].tolist(), zip(*block, strict=True), strict=True))
            read += block[1].size
            ready = [held.pop(place) for place in range(done, int(least[read]))]
            due = self._due[done : done + len(ready)]
            done += len(ready)
            topic, log_time = (np.array([message[i] for message in ready], np.int64) for i in (0, 1))
            for part in np.split(np.arange(len(ready)), np.flatnonzero(np.diff(log_time) < 0) + 1):
                yield topic[part], log_time[part], due[part], [ready[i][2] for i in part]

    def _number_of(self, topic: tuple[str, str]) -> int:
        if topic not in self._number:
            self._number[topic] = len(self.topics)
            self.topics.append(topic)
        return self._number[topic]
