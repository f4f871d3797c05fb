"""Whether channels of the last minutes contradict each other: a sign, exchanged pressures, a scale, clocks that are apart."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Sequence

import numpy as np

from ddh_twin_py.gap.recordings.contradictions import contradictions
from ddh_twin_py.nodes.base.node_base import TwinNode
from ddh_twin_py.nodes.tasks.health import Report
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording, drive_stream, hydraulic_stream
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.telemetry.ticks import Samples, Tick

WINDOW, LEAST, LOOK = 300.0, 180.0, 60.0
"""s of data that are looked at, at least, and between looks."""
_OF_A_TICK = 2  # samples of a stream that are kept of a tick, give or take one
_STREAMS = {DRIVE_TOPIC: drive_stream, HYDRAULIC_TOPIC: hydraulic_stream}


class ContradictionWatch:
    """Looks at the last minutes of drive and hydraulics now and then; what two looks say is told, see `contradictions`.

    Args:
        node: whose health tells it. rig: its geometry and load.
    """

    def __init__(self, node: TwinNode, rig: Rig) -> None:
        self._node, self._rig = node, rig
        self._ticks: deque[Tick] = deque()
        self._looked_ns = 0
        self._before: dict[str, str] = {}
        self.said: list[str] = []
        """What is told at present."""

    def add(self, ticks: Sequence[Tick]) -> None:
        """Take in what came; ticks after a restart have nothing to do with those before."""
        for tick in ticks:
            if tick.restart:
                self._ticks.clear()
                self._before = {}
            self._ticks.append(_thinned(tick))
        while self._ticks and (self._ticks[-1].end_ns - self._ticks[0].end_ns) * 1e-9 > WINDOW:
            self._ticks.popleft()
        if self._ticks and abs(self._ticks[-1].end_ns - self._looked_ns) * 1e-9 > LOOK:
            self._looked_ns = self._ticks[-1].end_ns
            if (self._ticks[-1].end_ns - self._ticks[0].end_ns) * 1e-9 > LEAST:
                self._look()

    def _look(self) -> None:
        now = {_without_figures(text): text for text in contradictions(self._recording(), self._rig)}
        told = {kind: text for kind, text in now.items() if kind in self._before}
        for kind, text in told.items():
            self._node.warn_once(("contradiction", kind), text)
        self.said = list(told.values())
        self._before = now

    def _recording(self) -> Recording:
        epoch_ns = self._ticks[0].start_ns
        streams = {}
        for topic, of in _STREAMS.items():
            samples = [own for tick in self._ticks if (own := tick.samples.get(topic)) is not None and len(own)]
            if samples:
                stamps = np.concatenate([own.stamp for own in samples])
                streams[topic] = of((stamps - epoch_ns) * 1e-9, np.concatenate([own.values for own in samples]))
        return Recording(f"the last {(self._ticks[-1].end_ns - epoch_ns) * 1e-9:.0f} s", epoch_ns, None, streams.get(DRIVE_TOPIC),
                         streams.get(HYDRAULIC_TOPIC), namespace=self._node.get_namespace().rstrip("/"))

    def judge(self, report: Report) -> str:
        """For `/diagnostics`."""
        report.add("window", WINDOW, "s")
        for text in self.said:
            report.warn(text)
        return "no two contradict each other"


def _thinned(tick: Tick) -> Tick:
    """A tick with some samples of what is looked at."""
    kept = {}
    for topic in _STREAMS:
        own = tick.samples.get(topic)
        if own is not None and len(own):
            every = slice(None, None, max(1, len(own) // _OF_A_TICK))
            kept[topic] = Samples(own.stamp[every], own.values[every])
    return Tick(tick.start_ns, tick.end_ns, tick.restart, kept, tick.gap)


def _without_figures(text: str) -> str:
    return re.sub(r"[-\d.]+", "", text)
