"""Many messages of one layout at once, without ROS.

A type that begins with a header and holds numbers beside strings that never change has its float64 values at fixed places of
its CDR. The places are found once, from an example that is serialised with a number of its own in every field.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from rosbags.interfaces import Nodetype

from ddh_twin_py.bags.message_types import know

_ENCAPSULATION = 4
_MARK = 1.0e200  # times 1, 2, 3 ...: no number of an example


@dataclass(frozen=True)
class Numbers:
    """A field that is an array of that many float64, to be told with each message."""

    count: int


class BulkMessages:
    """Composes messages of one type.

    Args:
        message_type: such as `sensor_msgs/msg/Temperature`; its first field is a header.
        frame_id: of the header.
        constants: what stays the same in all messages, by field. A float64 or bool that is not named here is told with each
            message, as is an array that is `Numbers`; a list of mappings is a list of nested messages, whose float64 are named
            with a dot (`losses.power`).

    Attributes:
        names: of the values that `compose` is told.

    Raises KeyError where the type's definition is nowhere.
    """

    def __init__(self, message_type: str, frame_id: str = "", constants: Mapping[str, object] | None = None) -> None:
        self.message_type = message_type
        self._store = know(message_type)
        self._marks: dict[str, list[float]] = {}
        self._flags: list[str] = []
        given = {"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": frame_id}, **(constants or {})}
        content = self._serialised(given)
        self._size = len(content)
        self._template = np.frombuffer(content + b"\0" * (-(len(content) - _ENCAPSULATION) % 8), np.uint8)
        words = self._template[_ENCAPSULATION:].view("<f8")
        self._places = {
            name: np.array([int(np.flatnonzero(words == mark)[0]) for mark in marks]) for name, marks in self._marks.items()
        }
        self._bools = {}
        for flag in self._flags:
            other = np.frombuffer(self._serialised({**given, flag: True}), np.uint8)
            (self._bools[flag],) = np.flatnonzero(other != self._template[: self._size])
        self.names = (*self._places, *self._bools)

    def compose(self, stamps_ns: np.ndarray, values: Mapping[str, np.ndarray | float]) -> list[bytes]:
        """n messages: stamps int64[n] ns; each value (n,), (n, m) or one number for all.

        Raises KeyError for a name that is missing, or none.
        """
        if values.keys() != set(self.names):
            odd = sorted(values.keys() ^ set(self.names))[0]
            raise KeyError(f"{self.message_type}: {odd!r} is {'none of its values' if odd in values else 'not given'}")
        rows = np.tile(self._template, (stamps_ns.size, 1))
        seconds, nanoseconds = np.divmod(np.asarray(stamps_ns, np.int64), 1_000_000_000)
        rows[:, 4:8] = seconds.astype("<i4")[:, None].view(np.uint8)
        rows[:, 8:12] = nanoseconds.astype("<u4")[:, None].view(np.uint8)
        words = rows[:, _ENCAPSULATION:].view("<f8")
        for name, value in values.items():
            if name in self._bools:
                rows[:, self._bools[name]] = value
            else:
                words[:, self._places[name]] = value if np.ndim(value) in (0, 2) else np.asarray(value)[:, None]
        return [row[: self._size].tobytes() for row in rows]

    def _serialised(self, given: Mapping[str, object]) -> bytes:
        self._marks.clear()
        self._flags.clear()
        return bytes(self._store.serialize_cdr(self._message(self.message_type, given, ""), self.message_type))

    def _mark(self, name: str) -> float:
        mark = _MARK * (1 + sum(map(len, self._marks.values())))
        self._marks.setdefault(name, []).append(mark)
        return mark

    def _message(self, message_type: str, given: Mapping[str, object], prefix: str) -> object:
        made = {}
        for field, (node, kind) in self._store.fielddefs[message_type][1]:
            name, value = prefix + field, given.get(field)
            if node is Nodetype.NAME:
                value = self._message(kind, value, f"{name}.")
            elif isinstance(value, Numbers):
                value = np.array([self._mark(name) for _ in range(value.count)])
            elif node is Nodetype.SEQUENCE and kind[0][0] is Nodetype.NAME:
                value = [self._message(kind[0][1], entry, f"{name}.") for entry in value]
            elif value is None and kind[0] == "float64":
                value = self._mark(name)
            elif value is None and kind[0] == "bool":
                self._flags.append(name)
                value = False
            made[field] = value
        return self._store.types[message_type](**made)
