"""Compose and parse messages of one layout in bulk.

The twin's own messages are a stamp, some names that never change, and numbers. rclpy converts
each field of each message between Python and C, 0.1 to 0.3 ms for a large one. Here it is worked
out once where each value lies (tests compare with the real serialiser); after that a batch of
messages is an array.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence

import numpy as np
from rclpy.serialization import serialize_message

from ddh_twin_py.bags.cdr import MOST_NANOSEC, first_odd_nanosec, nanosec_words
from ddh_twin_py.nodes.base.deserialised import deserialised

_ENCAPSULATION = 4
_STAMP_BYTES = 8
_PADDED = 8  # bytes, whatever they hold, of which a serialiser puts fewer behind an array without values
STAMPED = _ENCAPSULATION + _STAMP_BYTES
"""Bytes of the shortest message that holds a stamp."""


class Layout:
    """Where the values of one kind of message lie in its CDR.

    `example` is a message with a header, and with all strings and array lengths as they will be.
    Its float64 fields, arrays of them, and float64 fields of nested arrays of messages are known
    by name (`temperature`, `losses.power`), its bools as well. `columns` maps each float64 name to
    its number of values, 0 for a single one. Raises TypeError for a field of another type.
    """

    def __init__(self, example: object) -> None:
        self.message_type = type(example)
        walk = _Walk()
        walk.message(example, "", top=True)
        self._size = _ENCAPSULATION + walk.at
        data = np.zeros(self._size + -walk.at % 8, np.uint8)  # padding at the end: whole words
        data[1] = 1  # little endian
        fixed = np.zeros(data.size, bool)
        for at, content in walk.fixed:
            data[_ENCAPSULATION + at : _ENCAPSULATION + at + len(content)] = np.frombuffer(content, np.uint8)
            fixed[_ENCAPSULATION + at : _ENCAPSULATION + at + len(content)] = True
        fixed[1] = True
        self._template = data
        self._fixed = np.flatnonzero(fixed)
        self._fixed_bytes = data[self._fixed]
        self._places = {name: np.array(places, np.intp) // 8 for name, places in walk.numbers.items()}
        self.columns = {name: 0 if name in walk.scalars else len(p) for name, p in walk.numbers.items()}
        self._scalars = frozenset(walk.scalars)
        self._bools = {name: _ENCAPSULATION + at for name, at in walk.bools.items()}

    def compose(self, stamps_ns: np.ndarray, values: Mapping[str, np.ndarray]) -> list[bytes]:
        """n messages: stamps int64[n] ns; each value (n,) or (n, m), or one number for all.

        Fields that are not named are 0 or False. Raises KeyError for a name that is none.
        """
        stamps = np.asarray(stamps_ns, np.int64)
        rows = np.tile(self._template, (stamps.size, 1))
        _put_stamps(rows, stamps)
        words = rows[:, _ENCAPSULATION:].view("<f8")
        for name, value in values.items():
            if name in self._bools:
                rows[:, self._bools[name]] = value
                continue
            place = self._places[name]
            words[:, place] = value if np.ndim(value) == 2 or np.ndim(value) == 0 else np.asarray(value)[:, None]
        return [row[: self._size].tobytes() for row in rows]

    def parse(self, messages: Sequence[bytes]) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
        """Stamps int64[n] and values by name, (n,) or (n, m); None where a message has another layout, or a stamp that is none."""
        if any(not self._size <= len(message) < self._size + _PADDED for message in messages):
            return None
        joined = np.frombuffer(b"".join(message[: self._size] for message in messages), np.uint8).reshape(len(messages), self._size)
        if not (joined[:, self._fixed] == self._fixed_bytes).all():
            return None
        rows = np.zeros((len(messages), self._template.size), np.uint8)
        rows[:, : self._size] = joined
        stamps = np.ascontiguousarray(rows[:, _ENCAPSULATION : _ENCAPSULATION + _STAMP_BYTES])
        seconds, nanoseconds = stamps.view("<i4")[:, 0].astype(np.int64), stamps.view("<u4")[:, 1]
        if (nanoseconds > MOST_NANOSEC).any():
            return None
        words = rows[:, _ENCAPSULATION:].view("<f8")
        values: dict[str, np.ndarray] = {}
        for name, place in self._places.items():
            values[name] = words[:, place[0]] if name in self._scalars else words[:, place]
        for name, place in self._bools.items():
            values[name] = rows[:, place].astype(bool)
        return seconds * 1_000_000_000 + nanoseconds, values


class BulkParser:
    """Parses messages of a type whose strings and lengths hardly ever change.

    `example` is the message whose layout is in force, with the names in it; `unreadable` counts messages that are none of the type, and
    those in which numbers and the names that stand before them are not equally many, or whose stamp is none; `why`: of the first of these,
    '' where it was none of the type.
    """

    def __init__(self, message_type: type) -> None:
        self.message_type = message_type
        self._layout: Layout | None = None
        self.example: object | None = None
        self.unreadable, self.why = 0, ""

    def parse(self, messages: Sequence[bytes]) -> list[tuple[object, np.ndarray, dict[str, np.ndarray]]]:
        """Runs of messages of one layout, in order: example, stamps int64[n] ns, values by name; (n, 0) of a list without entries.

        A message that is unreadable is left out and counted.
        """
        runs = []
        while messages:
            parsed = self._layout.parse(messages) if self._layout is not None else None
            if parsed is not None:
                runs.append((self.example, *parsed))
                break
            count = 0 if self._layout is None else self._same(messages)
            parsed = self._layout.parse(messages[:count]) if count else self._anew(messages[0])
            if parsed is None:
                if not self.unreadable and (nanosec := first_odd_nanosec(messages[:1])):
                    self.why = nanosec_words(nanosec)
                self.unreadable += 1
            else:
                runs.append((self.example, *parsed))
            messages = messages[max(count, 1) :]
        return runs

    def _anew(self, message: bytes) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
        """A message by a layout of its own, also where another serialiser wrote it; None where it is none of the type."""
        example = deserialised(message, self.message_type)
        if example is None or not _each_named(example):
            return None
        self.example, self._layout = example, Layout(example)
        return self._layout.parse([message]) or self._layout.parse([serialize_message(example)])

    def _same(self, messages: Sequence[bytes]) -> int:
        count = 0
        while count < len(messages) and self._layout.parse(messages[count : count + 1]) is not None:
            count += 1
        return count


def _each_named(message: object) -> bool:
    """Whether each array of numbers has as many as there are names in the array of names just before it, where one is."""
    before = ""
    for attribute, kind in message.get_fields_and_field_types().items():
        if kind == "sequence<double>" and before and len(getattr(message, attribute)) != len(getattr(message, before)):
            return False
        before = attribute if kind == "sequence<string>" else ""
    return True


def stamp_of(message: bytes) -> int:
    """Header stamp of a serialised message in ns; its type must begin with a header."""
    order = "little" if message[1] & 1 else "big"
    seconds = int.from_bytes(message[4:8], order, signed=True)
    return seconds * 1_000_000_000 + nanosec_of(message)


def nanosec_of(message: bytes) -> int:
    """Of that stamp, ns beside its seconds as they stand there."""
    return int.from_bytes(message[8:12], "little" if message[1] & 1 else "big")


def _put_stamps(rows: np.ndarray, stamps: np.ndarray) -> None:
    seconds, nanoseconds = np.divmod(stamps, 1_000_000_000)
    rows[:, 4:8] = seconds.astype("<i4")[:, None].view(np.uint8)
    rows[:, 8:12] = nanoseconds.astype("<u4")[:, None].view(np.uint8)


class _Walk:
    """Lays a message out as XCDR1 does: each value aligned to its size, counted behind the encapsulation."""

    def __init__(self) -> None:
        self.at = 0
        self.fixed: list[tuple[int, bytes]] = []  # strings, lengths
        self.numbers: dict[str, list[int]] = {}
        self.scalars: set[str] = set()
        self.bools: dict[str, int] = {}

    def message(self, message: object, prefix: str, top: bool = False) -> None:
        for attribute, kind in message.get_fields_and_field_types().items():
            value, name = getattr(message, attribute), prefix + attribute
            if kind == "double":
                if top:
                    self.scalars.add(name)
                self.numbers.setdefault(name, []).append(self._take(8, 8))
            elif kind == "sequence<double>":
                self._fix(len(value))
                self.numbers[name] = [self._take(8, 8) for _ in value]
            elif kind == "boolean":
                self.bools[name] = self._take(1, 1)
            elif kind == "string":
                self._string(value)
            elif kind == "sequence<string>":
                self._fix(len(value))
                for text in value:
                    self._string(text)
            elif kind == "std_msgs/Header" and self.at == 0:
                self._take(_STAMP_BYTES, 4)
                self._string(value.frame_id)
            elif isinstance(value, list) and kind.startswith("sequence<"):
                self._fix(len(value))
                for entry in value:
                    self.message(entry, f"{name}.")
                if not value:
                    self._without_entries(kind, f"{name}.")
            else:
                raise TypeError(f"{type(message).__name__}: field {name} is of type {kind}, which has no fixed layout")

    def _without_entries(self, kind: str, prefix: str) -> None:
        """Numbers of a list of messages, such as ``sequence<ddh_msgs/Residual>``, in which there is none: each has no value."""
        package, entry = kind.removeprefix("sequence<").removesuffix(">").split("/")
        fields = getattr(importlib.import_module(f"{package}.msg"), entry).get_fields_and_field_types()
        self.numbers.update({prefix + attribute: [] for attribute, of in fields.items() if of in ("double", "sequence<double>")})

    def _take(self, size: int, alignment: int) -> int:
        start = self.at + -self.at % alignment
        self.at = start + size
        return start

    def _fix(self, count: int) -> None:
        self.fixed.append((self._take(4, 4), count.to_bytes(4, "little")))

    def _string(self, text: str) -> None:
        content = text.encode() + b"\0"
        self._fix(len(content))
        self.fixed.append((self._take(len(content), 1), content))
