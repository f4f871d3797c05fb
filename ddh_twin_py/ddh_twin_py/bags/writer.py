"""Write rosbag2 folders (MCAP, zstd chunks) that survive the death of the process that writes them."""

from __future__ import annotations

import os
import struct
import threading
import zlib
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from rosbags.interfaces import Connection, Qos
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer, WriterError

from ddh_twin_py.bags.cdr import encode_stamped_floats
from ddh_twin_py.bags.compression import pack_chunk
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.mcap_storage import CHUNK_CRC
from ddh_twin_py.bags.message_types import know
from ddh_twin_py.bags.qos import LATCHED, RELIABLE, SENSOR_DATA
from ddh_twin_py.bags.topics import normalised
from ddh_twin_py.rig.files import whole_folder
from ddh_twin_py.telemetry.recording import Recording, RigInfo
from ddh_twin_py.telemetry.signals import (
    RIG_TOPIC,
    RIG_TYPE,
    TEMPERATURE_PREFIX,
    TOPIC_TYPES,
    ZERO_CELSIUS,
)

FLUSH_INTERVAL = 2.0  # s of wall time


class BagWriter:
    """Writes one rosbag2 folder; a context manager.

    Messages lie in memory for at most `flush_interval` seconds: then they go to the disk as a
    chunk, however few they are, by a thread that lives as long as the writer is open. A reader
    recovers all chunks of a writer that was killed. Leaving the context writes index and
    metadata.yaml, also after an exception. May be called from several threads.
    `shown` is the path that errors name, where it is another.
    Raises BagError when the folder exists, or when the disk can take no more.
    """

    def __init__(self, path: str | Path, flush_interval: float = FLUSH_INTERVAL, shown: str | Path | None = None) -> None:
        self.path = Path(path if shown is None else shown)
        self.message_count = 0
        self._interval = flush_interval
        self._lock = threading.Lock()
        self._closing = threading.Event()
        self._failure: OSError | None = None
        self._connections: dict[str, Connection] = {}
        self._kept: Counter[int] = Counter()
        try:
            self._writer = Writer(Path(path), version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP)
            self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            self._writer.open()
            self._writer.storage.compressor = pack_chunk
            self._writer.storage.close_chunk = self._close_chunk
            self._flush()  # the header, so that even an empty file says what it is
        except (WriterError, OSError) as error:
            raise _cannot(self.path, error) from None
        self._thread = threading.Thread(target=self._keep_flushing, name="bag flush", daemon=True)
        self._thread.start()

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Write what is left, the index and metadata.yaml. Does nothing the second time.

        Raises BagError when the disk took no more, now or before: the file then ends with the last chunk that it took whole.
        """
        if self._closing.is_set():
            return
        self._closing.set()
        self._thread.join()
        with self._lock:
            if self._failure is not None:
                _abandon(self._writer.storage)
                raise _cannot(self.path, self._failure)
            try:
                if not self.message_count:
                    self._writer.min_timestamp = 0
                    self._writer.storage.message_start_time = 0
                self._writer.close()
            except OSError as error:
                raise _cannot(self.path, error) from None

    def write_raw(
        self, topic: str, message_type: str, qos: Sequence[Qos] | None, log_time_ns: int, cdr: bytes | memoryview
    ) -> None:
        """Write one serialised message; `topic` absolute, `qos` as offered (None: reliable).

        Type and profile of a topic are those of its first message.
        Raises BagError when the type's definition is nowhere, or the disk can take no more.
        """
        with self._lock:
            if self._failure is not None:
                raise _cannot(self.path, self._failure)
            connection = self._connections.get(topic)
            if connection is None:
                connection = self._connect(topic, message_type, qos)
            try:
                self._writer.write(connection, log_time_ns, cdr)
            except OSError as error:
                self._failure = error
                raise _cannot(self.path, error) from None
            self.message_count += 1

    def write_message(self, topic: str, message: object, log_time_ns: int, qos: Sequence[Qos] | None = None) -> None:
        """Write one message made of the types of `message_types.typestore()`."""
        message_type = message.__msgtype__
        self.write_raw(topic, message_type, qos, log_time_ns, know(message_type).serialize_cdr(message, message_type))

    def write_rig(self, rig: RigInfo, stamp_ns: int, namespace: str = "/ddh", log_time_ns: int | None = None) -> None:
        """Write the rig's own message, once per bag."""
        store = know(RIG_TYPE)
        header = store.types["std_msgs/msg/Header"](_stamp(store, stamp_ns), "")
        message = store.types[RIG_TYPE](header, rig.rig_id, rig.oil_grade, float(rig.payload_mass))
        topic = f"{normalised(namespace)}/{RIG_TOPIC}"
        self.write_message(topic, message, stamp_ns if log_time_ns is None else log_time_ns, LATCHED)

    def flush(self) -> None:
        """Put everything written so far on the disk. Raises BagError when it can take no more."""
        with self._lock:
            self._try_flush()
            if self._failure is not None:
                raise _cannot(self.path, self._failure)

    def _connect(self, topic: str, message_type: str, qos: Sequence[Qos] | None) -> Connection:
        try:
            store = know(message_type)
        except KeyError as error:
            raise BagError(f"{self.path}: topic {topic}: {error.args[0]}") from None
        profile = RELIABLE if qos is None else qos
        connection = self._writer.add_connection(
            topic, message_type, typestore=store, offered_qos_profiles=list(profile)
        )
        self._connections[topic] = connection
        return connection

    def _keep_flushing(self) -> None:
        while self._failure is None and not self._closing.wait(self._interval):
            with self._lock:
                self._try_flush()

    def _try_flush(self) -> None:
        """Flush unless something failed before: what comes after a chunk that could not be written cannot be read."""
        if self._failure is None:
            try:
                self._flush()
            except OSError as error:
                self._failure = error

    @property
    def on_disk(self) -> dict[str, int]:
        """How many messages of each topic are in the file already."""
        with self._lock:
            return {topic: self._kept[connection.id] for topic, connection in self._connections.items()}

    def _close_chunk(self) -> None:
        storage = self._writer.storage
        held = {number: len(messages) for number, messages in storage.chunk.msgs.items()}
        _close_chunk(storage)
        self._kept.update(held)

    def _flush(self) -> None:
        storage = self._writer.storage
        if storage.chunk.msgs:
            storage.close_chunk()
        storage.bio.flush()
        os.fsync(storage.bio.fileno())


def _close_chunk(storage) -> None:
    """Close the pending chunk of rosbags' MCAP storage and put the CRC-32 of its unpacked records into its head, which rosbags leaves 0.

    Where that fails the file is closed and ends where the chunk began.
    Source: MCAP format specification, Chunk (op=0x06), `uncompressed_crc`.
    """
    crc = zlib.crc32(storage.chunk.bio.getbuffer())
    begin = storage.bio.tell()
    try:
        type(storage).close_chunk(storage)
        end = storage.bio.tell()
        storage.bio.seek(begin + CHUNK_CRC)
        storage.bio.write(struct.pack("<I", crc))
        storage.bio.seek(end)
    except OSError:
        _abandon(storage)
        os.truncate(storage.path, begin)
        raise


def _abandon(storage) -> None:
    """Close the file without what is still to be written; what its buffer holds may go to the disk."""
    with suppress(OSError):
        storage.bio.close()


@contextmanager
def whole_bag(path: str | Path, flush_interval: float = FLUSH_INTERVAL) -> Iterator[BagWriter]:
    """A writer whose folder is there once the bag is whole; where that fails, nothing is left behind.

    Raises BagError when the folder exists, or when the disk can take no more.
    """
    if os.path.lexists(path):
        raise BagError(f"{path} cannot be written: it exists already")
    try:
        with whole_folder(path) as folder, BagWriter(folder, flush_interval, path) as writer:
            yield writer
    except OSError as error:
        raise _cannot(path, error) from None


def _cannot(path: str | Path, error: Exception) -> BagError:
    return BagError(f"{path} cannot be written: {' '.join(str(getattr(error, 'strerror', None) or error).split())}")


def write_recording(
    path: str | Path,
    recording: Recording,
    namespace: str = "/ddh",
    latency_ns: int = 1_000_000,
    flush_interval: float = FLUSH_INTERVAL,
) -> Path:
    """Write a recording as a bag and return its path.

    Samples keep their order within each stream; the log time is the stamp plus `latency_ns`,
    and never runs backwards within a stream, as a recorder's own clock would not.
    Temperatures are written in degC. Raises BagError as `whole_bag` does, and where a stamp is none of ROS 2.
    """
    namespace = normalised(namespace)
    parts = []
    for relative, stream in recording.streams():
        stamps = stream.stamps(recording.epoch_ns)
        _check_stamps(path, f"{namespace}/{relative}", stamps, latency_ns)
        values = stream.values
        frame = "ddh"
        if relative.startswith(TEMPERATURE_PREFIX):
            frame = relative.removeprefix(TEMPERATURE_PREFIX)
            values = values - np.array([ZERO_CELSIUS, 0.0])
        log_times = np.maximum.accumulate(stamps + latency_ns)
        parts.append((relative, log_times, encode_stamped_floats(stamps, values, frame)))
    if recording.rig is not None:
        _check_stamps(path, f"{namespace}/{RIG_TOPIC}", np.array([recording.epoch_ns]), 0)
    with whole_bag(path, flush_interval) as writer:
        if recording.rig is not None:
            writer.write_rig(recording.rig, recording.epoch_ns, namespace)
        if parts:
            source = np.concatenate([np.full(times.size, k) for k, (_, times, _) in enumerate(parts)])
            row = np.concatenate([np.arange(times.size) for _, times, _ in parts])
            log_time = np.concatenate([times for _, times, _ in parts])
            order = np.argsort(log_time, kind="stable")
            for k, i, at in zip(source[order].tolist(), row[order].tolist(), log_time[order].tolist(), strict=True):
                relative, _, messages = parts[k]
                writer.write_raw(f"{namespace}/{relative}", TOPIC_TYPES[relative], SENSOR_DATA, at, messages[i].data)
    return writer.path


def _check_stamps(path: str | Path, topic: str, stamps: np.ndarray, latency_ns: int) -> None:
    """Raises BagError where a stamp, int64[n] ns, is beyond the 32 bits that ROS 2 has for its seconds, or its log time before 1970."""
    beyond = np.flatnonzero((stamps >= 2**31 * 1_000_000_000) | (stamps < -latency_ns))
    if beyond.size:
        said = f"{stamps[beyond[0]] * 1e-9:.1f} s since 1970"
        raise BagError(f"{path}: {topic}: stamp {said} cannot be written, allowed are 0 to below {2**31} s (January 2038)")


def _stamp(store, stamp_ns: int):
    return store.types["builtin_interfaces/msg/Time"](stamp_ns // 1_000_000_000, stamp_ns % 1_000_000_000)


__all__ = ["FLUSH_INTERVAL", "BagWriter", "whole_bag", "write_recording"]
