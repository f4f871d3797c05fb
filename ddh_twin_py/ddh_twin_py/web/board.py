"""What the page shows right now: numbers as they come, and documents that change now and then."""

from __future__ import annotations

import json
import math
import threading
import time
from collections.abc import Callable, Sequence

import numpy as np

from ddh_twin_py.web.binning import RowMeans
from ddh_twin_py.web.frames import Block, encode
from ddh_twin_py.web.history import History, row_index
from ddh_twin_py.web.streams import BY_NAME, COLUMNS, FIRST, NUMBER, PLACE, STREAMS, Stream

STRAGGLE = 10
"""Rows (0.5 s) that a message of the clock's stream may be late; a larger step back is a clock that jumped."""
AHEAD = 40
"""Rows (2 s) by which a stream may be ahead of the clock of the page; what is further ahead is of the time before a jump."""
MOST_ROWS = 8
"""Rows of a stream in one frame: at higher rates of a replay the rest is in the history alone."""
CLOCKS = ("drive", "hydraulics")
"""Streams whose stamps are the page's clock, the first that comes; without any it is the newest stamp of all."""
SILENT = 3.0
"""s of wall time without a message, from which a stream is not the clock, so that the others go on without it."""


class Board:
    """Takes streams and documents in, gives frames out; may be used from several threads."""

    def __init__(self, wall: Callable[[], float] = time.monotonic) -> None:
        """``wall`` gives s of wall time."""
        self._lock = threading.RLock()
        self._wall = wall
        self._heard: dict[str, float] = {}  # s of wall time at which each stream came last
        self.history = History(len(COLUMNS))
        self._latest = np.full(len(COLUMNS), np.nan, np.float32)
        self._newest: dict[str, int] = {}  # row of the newest values of each stream
        self._means = {stream.name: RowMeans(len(stream.fields)) for stream in STREAMS if stream.raw}
        self._fresh: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
        self._documents: dict[str, str] = {}
        self._changed: set[str] = set()
        self._data: dict[str, object] = {}
        self.now = 0  # row of the page's clock
        self.jumps = 0
        self._frame = 0

    # --- numbers -----------------------------------------------------------------------------

    def take(self, name: str, stamps_ns: np.ndarray, values: np.ndarray) -> None:
        """Messages of one stream in the order in which they came: stamps int64 (n,) in ns, values (n, fields)."""
        with self._lock:
            stream = BY_NAME[name]
            if stream.raw:
                self._take_rows(stream, *self._means[name].add(stamps_ns, values))
            else:
                self._take_rows(stream, row_index(stamps_ns), values)

    def settle(self, name: str) -> None:
        """Nothing more came on a stream of samples for a while: show what is in hand."""
        with self._lock:
            self._take_rows(BY_NAME[name], *self._means[name].flush())

    def _take_rows(self, stream: Stream, index: np.ndarray, values: np.ndarray) -> None:
        if not index.size:
            return
        self._heard[stream.name] = self._wall()
        if self._clock() in (stream.name, None):
            while (back := self._steps_back(stream, index)).size:
                self._place(stream, index[: back[0]], values[: back[0]])
                index, values = index[back[0] :], values[back[0] :]
                self.jumps += 1
                self.now = int(index[0])
                self._forget(stream)
        elif self._newest.get(stream.name, -1) > self.now + AHEAD:
            self._forget(stream)
        self._place(stream, index, values)

    def _steps_back(self, stream: Stream, index: np.ndarray) -> np.ndarray:
        """Where rows lie before the newest ahead of them."""
        before = np.maximum.accumulate(np.concatenate(([self._newest.get(stream.name, -1)], index[:-1])))
        return np.flatnonzero(index < before - STRAGGLE)

    def _place(self, stream: Stream, index: np.ndarray, values: np.ndarray) -> None:
        """Rows of one run of the clock, each to its place."""
        if not index.size:
            return
        self._advance_clock(stream, int(index.max()))
        wanted = (index <= self.now + AHEAD) & (index > self.now + AHEAD - self.history.reach)
        if not wanted.any():
            return
        order = np.argsort(index[wanted], kind="stable")
        index, values = index[wanted][order], values[wanted][order].astype(np.float32)
        last = np.append(index[1:] != index[:-1], True)
        self._keep(stream, index[last], values[last])

    def _keep(self, stream: Stream, index: np.ndarray, values: np.ndarray) -> None:
        """Rows in ascending order; what comes late goes to its place and is not the newest."""
        self.history.write(FIRST[stream.name], index, values)
        self._fresh.setdefault(stream.name, []).append((index, values))
        if index[-1] < self._newest.get(stream.name, -1):
            return
        self._newest[stream.name] = int(index[-1])
        latest = self._latest[FIRST[stream.name] : FIRST[stream.name] + len(stream.fields)]
        latest[:] = np.where(np.isnan(values[-1]), latest, values[-1]) if stream.sparse else values[-1]

    def _forget(self, stream: Stream) -> None:
        """The clock jumped back to `now`: what this stream said of later times is of another run."""
        self.history.forget_from(FIRST[stream.name], len(stream.fields), self.now)
        self._newest[stream.name] = -1
        self._fresh.pop(stream.name, None)

    def _clock(self) -> str | None:
        since = self._wall() - SILENT
        return next((name for name in CLOCKS if name in self._newest and self._heard[name] > since), None)

    def _advance_clock(self, stream: Stream, index: int) -> None:
        clock = self._clock()
        if clock is None and stream.name in CLOCKS or clock == stream.name:
            self.now = index
        elif clock is None:
            self.now = max(self.now, index)

    def latest(self, column: str) -> float:
        """Newest value of a column, NaN where nothing came yet."""
        return float(self._latest[PLACE[column]])

    # --- documents ---------------------------------------------------------------------------

    def put(self, key: str, data: object) -> None:
        """A document, sent to every page where it differs from what was sent before. NaN and infinity become null."""
        text = _json({"doc": key, "data": data})
        with self._lock:
            if self._documents.get(key) != text:
                self._documents[key] = text
                self._data[key] = data
                self._changed.add(key)

    def document(self, key: str) -> object:
        """The newest document of that name, None where there is none."""
        return self._data.get(key)

    def texts(self, keys: Sequence[str] | None = None) -> dict[str, str]:
        """Documents as they are sent, all where none is named."""
        with self._lock:
            return {key: self._documents[key] for key in (self._documents if keys is None else keys)}

    def changed(self) -> list[str]:
        """Documents that have changed since the last call."""
        with self._lock:
            keys, self._changed = sorted(self._changed), set()
            return keys

    # --- frames ------------------------------------------------------------------------------

    def frame(self) -> bytes:
        """What is new since the last frame, encoded once for all pages."""
        with self._lock:
            blocks = [Block(NUMBER[name], *_thinned(parts)) for name, parts in self._fresh.items()]
            self._fresh = {}
            self._frame += 1
            return encode(self._frame, self.now, blocks)

    def snapshot(self) -> bytes:
        """The newest values of every stream, with the number of the last frame: for a page that has missed some."""
        with self._lock:
            blocks = []
            for name, index in self._newest.items():
                if index < 0:
                    continue
                first, width = FIRST[name], len(BY_NAME[name].fields)
                blocks.append(Block(NUMBER[name], np.array([index]), self._latest[None, first : first + width]))
            return encode(self._frame, self.now, blocks)

    def look_back(self, level: int, columns: Sequence[str], seconds: float) -> tuple[int, np.ndarray]:
        """See `History.read`, up to the page's clock and the rows that run ahead of it."""
        with self._lock:
            return self.history.read(level, [PLACE[column] for column in columns], self.now, seconds)

    def state(self) -> dict[str, object]:
        """Everything as numbers and documents, for other programs."""
        with self._lock:
            values = {column: _finite(float(value)) for column, value in zip(COLUMNS, self._latest, strict=True)}
            return {"row": self.now, "values": values, **{key: _finite(data) for key, data in self._data.items()}}


def _thinned(parts: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    index, values = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    if index.size <= MOST_ROWS:
        return index, values
    chosen = np.linspace(0, index.size - 1, MOST_ROWS + 1).round().astype(int)[1:]
    return index[chosen], values[chosen]


def _json(data: object) -> str:
    return json.dumps(_finite(data), separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def _finite(data: object) -> object:
    if isinstance(data, dict):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, (list, tuple)):
        return [_finite(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data
