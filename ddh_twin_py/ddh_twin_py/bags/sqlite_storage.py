"""Read SQLite3 files of rosbag2 (all schema versions that rosbags knows), in blocks."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

import apsw
import numpy as np
from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag2 import ReaderError
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.bags.storage import Block, Channel

_MAGIC = b"SQLite format 3\0"
_MESSAGES_PER_BLOCK = 20_000
_ENCODINGS = {MessageDefinitionFormat.MSG: "ros2msg", MessageDefinitionFormat.IDL: "ros2idl"}


class SqliteStorage:
    """One .db3 file, opened. Raises BagError when it is no database of rosbag2, or too damaged to be opened."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.damage: list[str] = []
        self.remarks: list[str] = []
        if path.stat().st_size == 0:
            raise BagError(f"{path} is empty: 0 bytes, an SQLite3 file has at least 512")
        self._reader = Sqlite3Reader(path)
        try:
            self._reader.open()
        except (ReaderError, apsw.Error, UnicodeDecodeError) as error:
            if _damaged(path, error):
                raise BagError(f"{path} is a damaged SQLite3 file: {_line(error.__cause__ or error)}; {_saving(path)}") from None
            raise BagError(f"{path} is no SQLite3 file of rosbag2: {_line(error)}") from None
        self.channels = {
            connection.id: Channel(
                connection.topic,
                connection.msgtype,
                connection.msgdef.data,
                _ENCODINGS.get(connection.msgdef.format, ""),
                connection.digest,
                connection.ext.serialization_format,
            )
            for connection in self._reader.connections
        }

    def blocks(self) -> Iterator[Block]:
        """Raw messages in order of log time; what cannot be read is told in `damage`."""
        total = max(1, self._reader.metadata.message_count)
        done, odd = 0, 0
        rows: list[tuple[int, int, bytes]] = []
        try:
            for connection, log_time, data in self._reader.messages(self._reader.connections):
                if not isinstance(log_time, int) or not isinstance(data, bytes):
                    odd += 1
                    continue
                rows.append((connection.id, log_time, data))
                if len(rows) == _MESSAGES_PER_BLOCK:
                    done += len(rows)
                    yield _block(rows, done / total)
                    rows = []
        except (ReaderError, apsw.Error) as error:
            self.damage.append(f"is damaged: {_line(error)}")
        finally:
            self._reader.close()
        if odd:
            self.damage.append(f"is damaged: {odd} of its messages have no whole number as time or no bytes as content")
        if rows:
            yield _block(rows, 1.0)


def _damaged(path: Path, error: Exception) -> bool:
    """Whether a file that cannot be opened is SQLite3 all the same: it begins as one, and its pages or texts are not as they should be."""
    with path.open("rb") as file:
        begins = file.read(len(_MAGIC)) == _MAGIC
    return begins and isinstance(error.__cause__ or error, (apsw.CorruptError, apsw.NotADBError, UnicodeDecodeError))


def _saving(path: Path) -> str:
    file, saved = shlex.quote(str(path)), shlex.quote(f"saved_{path.name}")
    return f"what is left of it goes into another by: sqlite3 {file} .dump | sed 's/^ROLLBACK.*/COMMIT;/' | sqlite3 {saved}"


def _block(rows: list[tuple[int, int, bytes]], position: float) -> Block:
    channel, log_time, data = zip(*rows, strict=True)
    size = np.fromiter(map(len, data), np.int64, len(data))
    return Block(
        np.frombuffer(b"".join(data), np.uint8),
        np.array(channel, np.int64),
        np.array(log_time, np.int64),
        np.concatenate(([0], np.cumsum(size)[:-1])),
        size,
        position,
    )


def _line(error: Exception) -> str:
    return " ".join(str(error).split())
