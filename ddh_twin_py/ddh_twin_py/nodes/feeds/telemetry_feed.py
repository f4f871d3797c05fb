"""Telemetry as ticks: subscriptions, decoding, screening and alignment of one node."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import compress, islice
from operator import itemgetter
from time import time_ns

import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import Temperature

from ddh_msgs.msg import DriveTelemetry, HydraulicTelemetry
from ddh_twin_py.bags.cdr import first_odd_nanosec, floats_of_messages, nanosec_words
from ddh_twin_py.nodes.base.inputs import Input, Inputs
from ddh_twin_py.nodes.messages.conversion import to_kelvin
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.screening.alike_watch import AlikeWatch
from ddh_twin_py.telemetry.screening.screening import StreamScreen
from ddh_twin_py.telemetry.signals import (
    DRIVE_TOPIC,
    HYDRAULIC_TOPIC,
    MACHINE_FIELDS,
    TEMPERATURE_FIELDS,
    TEMPERATURE_PREFIX,
)
from ddh_twin_py.telemetry.ticks import Tick
from ddh_twin_py.telemetry.units.unit_scales import UnitScales
from ddh_twin_py.twin.sensor_errors import delay_ns

_STOOD, _COMES = 1_000_000_000, 500_000_000
"""ns between two looks after which a node may have stood still, and from the second look until all that waited for it has come."""
_EDGE = 250_000_000  # ns at either end of that time in which messages may have come all the same


def field_count(topic: str) -> int:
    """Numbers in one sample of a telemetry topic."""
    return len(TEMPERATURE_FIELDS if topic.startswith(TEMPERATURE_PREFIX) else MACHINE_FIELDS[topic])


def message_type(topic: str) -> type:
    """Message class of a telemetry topic."""
    return {DRIVE_TOPIC: DriveTelemetry, HYDRAULIC_TOPIC: HydraulicTelemetry}.get(topic, Temperature)


class TelemetryFeed:
    """Subscribes to telemetry topics and cuts what comes into ticks.

    `awaited` names the streams that a tick waits for, see `TickAligner`; `others` maps further
    streams of the aligner, which the node fills itself through `collect` and which are computed from
    telemetry, to their width; `keep_late` are streams whose late samples the node uses.
    What was collected is aligned in the order in which it came, all topics together: a node that was
    busy finds seconds of each, and a clock that jumped in them jumped once for all. Where the process itself stood still, nothing came
    meanwhile, and then all of one topic after all of another: that is taken together, in the order of its stamps.
    Temperature topics that are in the unit of one that is refused for it are not used either (`alike`).
    """

    def __init__(
        self,
        node: Node,
        rig: Rig,
        topics: Collection[str],
        awaited: Collection[str],
        interval: float,
        reorder_window: float,
        timeout: float,
        others: dict[str, int] | None = None,
        keep_late: Collection[str] = (),
    ) -> None:
        noise, scales = {name: spec.noise for name, spec in rig.sensors.items()}, UnitScales.of(rig)
        self.inputs, self.awaited = Inputs(node), tuple(awaited)
        self.screens = {topic: StreamScreen(topic, noise, reorder_window, scales) for topic in topics}
        self.alike = AlikeWatch(self.screens)
        for topic in topics:
            self.inputs.add(topic, message_type(topic))
        widths = {topic: field_count(topic) for topic in topics} | (others or {})
        self._delay = {topic: delay_ns(rig, topic) for topic in topics}
        self.last: dict[str, np.ndarray] = {}  # newest sample of each stream
        self._collected: list[tuple[int, str, int, Sequence[float]]] = []  # came at, stream, stamp, row
        self._looked = 0  # at what came last, ns of the computer's clock
        self._stood: tuple[int, int] | None = None  # two looks between which the process may have stood still, while that matters
        self.aligner = TickAligner(widths, interval, reorder_window, timeout, list(awaited), followers=tuple(others or ()),
                                   keep_late=keep_late)

    def take(self, wall: float) -> bool:
        """Take in all telemetry that waits; whether there is any to align. To be followed by `align`."""
        before, self._looked = self._looked, time_ns()
        if before and self._looked - before > _STOOD:
            self._stood = before, self._looked
        some = self._stood is not None and bool(self._collected)
        for topic, screen in self.screens.items():
            entry = self.inputs.all[topic]
            messages, came = self.inputs.take_timed(entry, wall)
            if messages:
                self._take(entry, screen, messages, came)
                some = True
        return some

    def collect(self, stream: str, came: Iterable[int], stamps: Iterable[int], rows: Iterable[Sequence[float]]) -> None:
        """Samples of one stream for `align`: when they came and their stamps, ns, and their rows."""
        self._collected += [(at, stream, stamp, row) for at, stamp, row in zip(came, stamps, rows, strict=True)]

    def align(self) -> None:
        """Give the aligner what was collected, in the order in which it came; of one time in the order of collection.

        Where the process stood still it waits until all has come, and `take` says meanwhile that there is some.
        """
        if self._stood is not None and self._stood_still(*self._stood):
            if self._stood[1] <= self._looked < self._stood[1] + _COMES:  # else also where the clock was set back meanwhile
                return
            order = _stamps_in_order
        else:
            order = _arrivals
        self._stood = None
        collected, self._collected = order(self._collected), []
        push = self.aligner.push
        for came, stream, stamp, row in collected:
            push(stream, stamp, row, came or None)  # tells repetitions from stragglers itself

    def _stood_still(self, begin: int, end: int) -> bool:
        """Whether the process stood still between two looks, ns, as nothing came then, rather than that it was busy."""
        return not any(begin + _EDGE < at < end - _EDGE for at, *_ in self._collected)

    def _take(self, entry: Input, screen: StreamScreen, messages: list[bytes], came: list[int]) -> None:
        stamps, values, sound = floats_of_messages(messages, field_count(entry.topic))
        if not sound.all():
            if not entry.told:
                nanosec = first_odd_nanosec(list(compress(messages, ~sound)))
                self.inputs.tell_left_out(entry, nanosec_words(nanosec) if nanosec else "")
            stamps, values = stamps[sound], values[sound]
            came = list(compress(came, sound))
        if entry.topic.startswith(TEMPERATURE_PREFIX):
            values[:, 0] = to_kelvin(values[:, 0])
        self.alike.take(entry.topic, stamps, values[:, 0])
        screened = screen.screen(stamps, values)
        if entry.topic in self.alike.refused:
            screened.values[:, 0] = np.nan
        stamps, kept = screened.stamp - self._delay[entry.topic], screened.kept
        self.collect(entry.topic, compress(came, kept), stamps[kept].tolist(), screened.values[kept])
        if len(screened.stamp):
            self.last[entry.topic] = screened.values[-1]
        entry.newest_ns = screen.newest_ns or 0
        lost = int((~sound).sum())
        entry.rejected += lost + int((~np.isfinite(screened.values[:, : len(screen.signals)])).any(axis=1).sum())

    def warm_up(self) -> None:
        """Load or compile what judges samples; forgets what it judged."""
        for topic in self.screens:
            StreamScreen(topic).screen([0], np.zeros((1, field_count(topic))))

    def ready(self, most: int) -> list[Tick]:
        """The next ticks that are complete, so many at most."""
        return self.without_refused(list(islice(self.aligner.ready(), most)))

    def flush(self) -> list[Tick]:
        """All ticks up to the newest sample, where nothing more comes for now."""
        return self.without_refused(list(self.aligner.flush()))

    def without_refused(self, ticks: list[Tick]) -> list[Tick]:
        """The ticks, in which no topic that is refused beside another (`alike`) has a value: they may have been cut before it was."""
        for topic in self.alike.refused:
            for tick in ticks:
                tick.samples[topic].values[:, 0] = np.nan
        return ticks


def _arrivals(collected: list[tuple]) -> list[tuple]:
    """What was collected, in the order in which it came."""
    return sorted(collected, key=itemgetter(0))


def _stamps_in_order(collected: list[tuple]) -> list[tuple]:
    """What was collected, in the order of stamps, that of each stream as it is; what goes back follows the newest before it."""
    newest: dict[str, int] = {}
    keys = []
    for _, stream, stamp, _ in collected:
        newest[stream] = max(stamp, newest.get(stream, stamp))
        keys.append(newest[stream])
    return [collected[i] for i in sorted(range(len(collected)), key=keys.__getitem__)]
