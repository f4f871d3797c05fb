"""Sort the raw messages of a bag by topic and decode them in bulk, block by block."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.bags.arrival import order_of_arrival
from ddh_twin_py.bags.cdr import odd_nanosec, stamped_floats
from ddh_twin_py.bags.compression import unpack_messages
from ddh_twin_py.bags.definitions import type_problem
from ddh_twin_py.bags.message_types import telemetry_typestore
from ddh_twin_py.bags.storage import EVER, Block, Channel, Storage, told
from ddh_twin_py.bags.topics import split_topic
from ddh_twin_py.telemetry.recording import RigInfo
from ddh_twin_py.telemetry.signals import (
    MACHINE_FIELDS,
    RIG_TOPIC,
    RIG_TYPE,
    TEMPERATURE_FIELDS,
)
from ddh_twin_py.telemetry.ticks import REORDER_WINDOW, to_ns


@dataclass(frozen=True)
class Arrived:
    """Messages of one topic in order of arrival: log times and stamps int64[n] ns, values float64[n, m]."""

    log_time: np.ndarray
    stamp: np.ndarray
    values: np.ndarray

    def at(self, chosen: np.ndarray) -> Arrived:
        """Those of given places, int[k], or where bool[n] is true."""
        return Arrived(self.log_time[chosen], self.stamp[chosen], self.values[chosen])


@dataclass
class Rows:
    """Decoded messages of one topic, a list entry per block."""

    log_time: list[np.ndarray] = field(default_factory=list)
    stamp: list[np.ndarray] = field(default_factory=list)
    values: list[np.ndarray] = field(default_factory=list)
    odd_stamps: int = 0  # messages whose stamp has nanoseconds of more than a second
    first_nanosec: int = 0  # of the first of these
    unreadable: int = 0  # messages too short for their type
    shortest: int = 0  # size in bytes of the first of these

    def leave_out(self, nanosec: np.ndarray, size: np.ndarray) -> None:
        """Note n messages that are not sound, of so many bytes, int64[n]; ``nanosec``, int64[k]: of those whose stamp is why."""
        if nanosec.size:
            self.first_nanosec = self.first_nanosec or int(nanosec[0])
            self.odd_stamps += nanosec.size
        if nanosec.size < size.size:
            self.shortest = self.shortest or int(size[0])
            self.unreadable += size.size - nanosec.size

    def joined(self) -> Arrived:
        """All of them in order of arrival. The parts are given up.

        Where the recorder's clock jumps or jitters and the stamps in the file go on, the messages came as they stand.
        """
        log_time, stamp = np.concatenate(self.log_time), np.concatenate(self.stamp)
        stored = Arrived(log_time, stamp, np.concatenate(self.values))
        self.log_time, self.stamp, self.values = [], [], []
        if np.any(log_time[1:] < log_time[:-1]) and np.any(stamp < np.maximum.accumulate(stamp) - to_ns(REORDER_WINDOW)):
            return stored.at(order_of_arrival(log_time))
        return stored


class Collector:
    """Everything read from the files of one bag, by absolute topic. `span`: of its log times as its metadata.yaml tells it, ns."""

    def __init__(self, message_compression: bool = False, span: tuple[int, int] = EVER) -> None:
        self.types: dict[str, str] = {}
        self.problems: dict[str, str] = {}  # known topics whose type cannot be used
        self.counts: Counter[str] = Counter()
        self.rows: dict[str, Rows] = {}
        self.rigs: dict[str, list[RigInfo]] = {}
        self.first, self.last = 2**63 - 1, 0  # log times of all, ns
        self._first_log, self._last_log = 2**63 - 1, 0  # of those that lie where chunk and metadata.yaml tell, ns
        self._message_compression = message_compression
        self._span = span

    def read(self, storage: Storage, hashes: dict[str, str], progress: Callable[[float], None] | None) -> None:
        """Read one opened file. `hashes`: type hashes by topic from metadata.yaml, where known."""
        for block in storage.blocks():
            self._take(block, storage.channels, hashes)
            if progress is not None:
                progress(block.position)
        for channel in storage.channels.values():
            self._know(channel, hashes)

    @property
    def lasting(self) -> float:
        """From the first to the last message by the recorder's clock, s; one outside of what chunk or metadata.yaml tell is damaged."""
        return max(0, self._last_log - self._first_log) * 1e-9

    def _know(self, channel: Channel, hashes: dict[str, str]) -> bool:
        """Register a channel; True where its messages are to be decoded."""
        split = split_topic(channel.topic)
        if channel.topic not in self.types or (channel.message_type != self.types[channel.topic] and split):
            self.types[channel.topic] = channel.message_type
            if split:
                if not channel.type_hash:
                    channel = Channel(**{**vars(channel), "type_hash": hashes.get(channel.topic, "")})
                problem = type_problem(channel, split[1])
                if problem:
                    self.problems.setdefault(channel.topic, problem)
        return split is not None and channel.topic not in self.problems

    def _take(self, block: Block, channels: dict[int, Channel], hashes: dict[str, str]) -> None:
        if not block.channel.size:
            return
        self.first, self.last = min(self.first, int(block.log_time.min())), max(self.last, int(block.log_time.max()))
        first, last = max(block.span[0], self._span[0]), min(block.span[1], self._span[1])
        told = block.log_time[(block.log_time >= first) & (block.log_time <= last)]  # any other says nothing of how long a recording is
        if told.size:
            self._first_log = min(self._first_log, int(told.min()))
            self._last_log = max(self._last_log, int(told.max()))
        for key in np.unique(block.channel):
            channel = channels.get(int(key))
            if channel is None:
                continue  # its definition was lost with a damaged chunk
            chosen = np.flatnonzero(block.channel == key)
            self.counts[channel.topic] += chosen.size
            if self._know(channel, hashes):
                self._decode(channel.topic, block, chosen)

    def _decode(self, topic: str, block: Block, chosen: np.ndarray) -> None:
        data, start, size = block.data, block.start[chosen], block.size[chosen]
        rows = self.rows.setdefault(topic, Rows())
        relative = split_topic(topic)[1]
        if self._message_compression:
            data, start, size = unpack_messages(data, start, size)
        if relative == RIG_TOPIC:
            for begin, length in zip(start, size, strict=True):
                self._decode_rig(topic, data[begin : begin + length].tobytes(), rows)
            return
        fields = len(MACHINE_FIELDS.get(relative, TEMPERATURE_FIELDS))
        stamp, values, sound = stamped_floats(data, start, size, fields)
        if not sound.all():
            rows.leave_out(odd_nanosec(data, start[~sound], size[~sound]), size[~sound])
            stamp, values = stamp[sound], values[sound]
        rows.log_time.append(block.log_time[chosen][sound])
        rows.stamp.append(stamp)
        rows.values.append(values)

    def _decode_rig(self, topic: str, message: bytes, rows: Rows) -> None:
        try:
            rig = telemetry_typestore().deserialize_cdr(message, RIG_TYPE)
        except Exception:  # rosbags raises many kinds on damaged bytes
            rows.shortest = rows.shortest or len(message)
            rows.unreadable += 1
            return
        self.rigs.setdefault(topic, []).append(RigInfo(told(rig.rig_id), told(rig.oil_grade), float(rig.payload_mass)))
