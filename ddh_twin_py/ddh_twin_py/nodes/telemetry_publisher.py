"""Publishes telemetry of a source at the pace of its stamps; both telemetry nodes are one of these.

Lifecycle: *configure* opens the source, *activate* begins to publish, *deactivate* stops. The nodes go
through the first two by themselves unless `autostart` is false. The order that matters is between the two
of them: both count from one start of the record, which drive_telemetry chooses each time that it is
activated and tells in the stamp of `rig`; pressure_telemetry publishes nothing until it has heard that, and
joins the record where it is by then.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np
from lifecycle_msgs.msg import State
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn

from ddh_msgs.msg import RigInfo
from ddh_twin_py.bags.cdr import encode_stamped_floats
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.node_base import POLL_PERIOD, TwinNode
from ddh_twin_py.nodes.base.parameters import NodeError, Parameter
from ddh_twin_py.nodes.base.times import ns_of, set_time
from ddh_twin_py.nodes.feeds.telemetry_feed import message_type
from ddh_twin_py.nodes.tasks.health import Health, Report
from ddh_twin_py.sources.protocol import Samples, Source, SourceError
from ddh_twin_py.sources.registry import open_source, source_modules
from ddh_twin_py.telemetry.signals import RIG_TOPIC, TEMPERATURE_PREFIX, ZERO_CELSIUS
from ddh_twin_py.telemetry.ticks import LONGEST_GAP

_BEHIND = 0.25  # s of data; what is older when a node joins is left out: listeners sort in what comes up to 0.5 s after the rest
_TOGETHER = 0.1  # s of data of which one topic may be sent before another one's
_DISCOVERY = 500_000_000  # ns from telling the start of the record to it, so that listeners get the first samples
_LOOP_PAUSE = 0.1  # s of data between the last sample of one round and the start of the next
_SET_BACK = 1.0  # s by which a clock that goes back was set
_BEHIND_LIMIT = 0.5  # s of wall time that publishing may lag before it is said


def parameters() -> tuple[Parameter, ...]:
    """Own parameters and the options of every source."""
    modules = source_modules()
    own = (
        Parameter("source", "", "Where telemetry comes from.", choices=("", *modules)),
        Parameter("rate", 1.0, "Speed against real time.", "1", 0.01, 100.0),
        Parameter("restamp", True, "Stamps begin now instead of when the source was recorded."),
        Parameter("reliable", False, "Publish reliably instead of best effort."),
        Parameter("loop", False, "Begin again at the end of the source; with restamp the stamps go on."),
        Parameter("autostart", True, "Configure and activate without being told to."),
    )
    return own + tuple(
        Parameter(f"{name}.{option.name}", option.default, option.description, option.unit, option.lowest)
        for name, module in modules.items()
        for option in module.OPTIONS
    )


class TelemetryPublisher(LifecycleNodeMixin, TwinNode):
    """Publishes some topics of a source. `leads`: chooses the start of the record and tells the others."""

    def __init__(self, name: str, topics: Collection[str], leads: bool) -> None:
        TwinNode.__init__(self, name, parameters())
        LifecycleNodeMixin.__init__(self)
        self._topics, self._leads = tuple(topics), leads
        self._source: Source | None = None
        self._epoch_ns: int | None = None  # when the record starts: of the node's clock, and as stamps are published
        self._told_ns: int | None = None  # the same as another node told it last, whether there is a source yet or not
        self._looked_ns: int | None = None  # the node's clock at the last look since it was activated
        self._rounds = 0.0  # s of data in the rounds before this one
        self._joining = True  # a record that may run already
        self._sending = False
        self._waiting: dict[str, Samples] = {}
        self._batches: Iterator[Mapping[str, Samples]] = iter(())
        self._behind = 0.0
        self.sent = dict.fromkeys(self._topics, 0)
        self._failure, self._starting = "", True
        profile = qos.stream(reliable=True, depth=200) if self.values["reliable"] else qos.SENSOR_DATA
        self._by_topic = {topic: self.create_publisher(message_type(topic), topic, profile) for topic in self._topics}
        if leads:
            self._rig_publisher = self.create_publisher(RigInfo, RIG_TOPIC, qos.LATCHED)
        else:
            self.create_subscription(RigInfo, RIG_TOPIC, self._take_rig, qos.LATCHED)
        self.health = Health(self)
        self.health.add("source", self._judge)
        self.every(POLL_PERIOD, self._pump)
        if self.values["autostart"]:
            self.trigger_configure()
            if self._source is None:
                raise NodeError(self._failure)
            if leads:
                self.trigger_activate()
        self._starting = False

    # --- lifecycle ---------------------------------------------------------------------------

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        name = self.values["source"]
        options = {key.split(".", 1)[1]: value for key, value in self.values.items() if key.startswith(f"{name}.")}
        try:
            if not name:
                raise SourceError(f"parameter source is empty; valid are {', '.join(source_modules())}")
            self._source = open_source(name, options)
        except SourceError as error:
            self._failure = str(error)
            if not self._starting:  # a node that cannot start says why as it ends
                self.get_logger().error(self._failure)
            return TransitionCallbackReturn.FAILURE
        for note in getattr(self._source, "notes", ()):
            self.get_logger().warning(note)
        if self._told_ns is not None:
            self._start_record(self._told_ns)
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        if self._leads:
            self._start_record(self.get_clock().now().nanoseconds + _DISCOVERY)
        elif self._epoch_ns is None:
            self.get_logger().warning(f"waits for {self.resolve_topic_name(RIG_TOPIC)}, whose stamp tells the start of the record")
        self._joining, self._sending, self._looked_ns = True, True, None
        if self._epoch_ns is not None:
            self._waiting = {topic: self._fresh(samples, self._now()) for topic, samples in self._waiting.items()}
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._sending = False
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.on_deactivate(state)
        return self.on_cleanup(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self._source, self._epoch_ns, self._waiting = None, None, {}
        return TransitionCallbackReturn.SUCCESS

    @property
    def active(self) -> bool:
        """Whether it publishes."""
        return self._state_machine.current_state[0] == State.PRIMARY_STATE_ACTIVE

    # --- start of the record -----------------------------------------------------------------

    def _start_record(self, epoch_ns: int) -> None:
        self._epoch_ns, self._rounds = epoch_ns, 0.0
        self._batches = self._source.batches(self._topics)
        self._waiting = {}
        self._joining = True
        if self._leads:
            self._publish_rig()

    def _publish_rig(self) -> None:
        message = RigInfo()
        set_time(message.header.stamp, self._epoch_ns)
        rig = self._source.rig
        if rig is not None:
            message.rig_id, message.oil_grade, message.payload_mass = rig.rig_id, rig.oil_grade, rig.payload_mass
        self._rig_publisher.publish(message)

    def _take_rig(self, message: RigInfo) -> None:
        epoch = ns_of(message.header.stamp)
        self._told_ns = epoch
        if epoch == self._epoch_ns or self._source is None:
            return
        if self._epoch_ns is not None:
            self.get_logger().info("the record was started anew, following")
        self._start_record(epoch)
        if self.values["autostart"] and not self.active:
            self.trigger_activate()

    # --- publishing --------------------------------------------------------------------------

    def _pump(self) -> None:
        if not self._sending or self._epoch_ns is None or self.finished:
            return
        if self._leads:
            self._follow_clock()
        now, started = self._now(), self.wall()
        while all(s.due.size == 0 or s.due[-1] <= now for s in self._waiting.values()):
            self._send(now)
            batch = next(self._batches, None)
            if batch is None:
                self._end()
                return
            self._waiting = {topic: self._fresh(samples, now) for topic, samples in batch.items()}
            nothing = not any(s.due.size for s in self._waiting.values())
            if nothing or self.wall() - started > 10.0 * POLL_PERIOD:
                break  # a source that waits or computes must not keep the node from listening
        self._send(now)
        self._judge_pace(now)

    def _follow_clock(self) -> None:
        """Begin the record anew where the node's clock was set: nobody waits for what is due in an hour, or works off a day at once."""
        before, self._looked_ns = self._looked_ns, self.get_clock().now().nanoseconds
        step = 0.0 if before is None else (self._looked_ns - before) * 1e-9
        if not -_SET_BACK <= step <= LONGEST_GAP:
            went = "back" if step < 0.0 else "ahead"
            self.warn_again(("clock", went), f"this node's clock went {went} by {abs(step):.1f} s; the record begins anew")
            self._start_record(self._looked_ns + _DISCOVERY)

    def _now(self) -> float:
        """s of data since the start of this round of the record."""
        return (self.get_clock().now().nanoseconds - self._epoch_ns) * 1e-9 * self.values["rate"] - self._rounds

    def _judge_pace(self, now: float) -> None:
        """How far publishing lags; a node has joined once it holds samples that are not long past."""
        waiting = [float(s.due[0]) for s in self._waiting.values() if s.due.size]
        self._behind = max(0.0, now - min(waiting)) if waiting else 0.0
        if self._joining:
            self._joining = not waiting or self._behind >= _BEHIND_LIMIT
        elif self._behind >= _BEHIND_LIMIT:
            self.warn_once("behind", f"the source is {self._behind:.1f} s behind {self.values['rate']:g} times real time")

    def _fresh(self, samples: Samples, now: float) -> Samples:
        """Without what is long past, where this node joins a record that runs already."""
        if not self._joining or not samples.due.size or samples.due[0] > now - _BEHIND:
            return samples
        return _part(samples, int(np.searchsorted(samples.due, now - _BEHIND)), samples.due.size)

    def _send(self, now: float) -> None:
        for topic, samples in pieces(self._waiting, now):
            self._publish(topic, samples)

    def _publish(self, topic: str, samples: Samples) -> None:
        stamps, values, frame = samples.stamp, samples.values, "ddh"
        if self.values["restamp"]:
            stamps = stamps - self._source.start_ns + self._epoch_ns + round(self._rounds * 1e9)
        if topic.startswith(TEMPERATURE_PREFIX):
            values, frame = values - np.array([ZERO_CELSIUS, 0.0]), topic.removeprefix(TEMPERATURE_PREFIX)
        publisher = self._by_topic[topic]
        for message in encode_stamped_floats(stamps, values, frame):
            publisher.publish(message.tobytes())
        self.sent[topic] += samples.due.size

    def _end(self) -> None:
        if self.values["loop"] and self._source.seekable:
            self.get_logger().info("end of the source, beginning again")
            self._rounds += self._source.duration + _LOOP_PAUSE  # the same in both telemetry nodes
            self._batches = self._source.batches(self._topics)
            return
        self.get_logger().info(f"end of the source: {sum(self.sent.values())} messages in all")
        self.finished = True

    def _judge(self, report: Report) -> str:
        report.add("messages sent", sum(self.sent.values()), "1")
        report.add("behind", self._behind, "s")
        report.add("behind limit", _BEHIND_LIMIT, "s")
        if self._behind > _BEHIND_LIMIT:
            report.warn(f"{self._behind:.1f} s behind real time")
        if not self.active:
            report.warn("inactive" if self._epoch_ns is not None or self._leads else "waits for the start of the record on rig")
        return f"publishing from {self.values['source']}"


def pieces(waiting: dict[str, Samples], now: float) -> Iterator[tuple[str, Samples]]:
    """Take what is due from ``waiting``, a short time of all topics after the other: a node that was behind sends no topic's as late."""
    while (first := min((float(s.due[0]) for s in waiting.values() if s.due.size), default=np.inf)) <= now:
        for topic, samples in waiting.items():
            count = int(np.searchsorted(samples.due, min(now, first + _TOGETHER), side="right"))
            if count:
                waiting[topic] = _part(samples, count, samples.due.size)
                yield topic, _part(samples, 0, count)


def _part(samples: Samples, first: int, last: int) -> Samples:
    return Samples(samples.due[first:last], samples.stamp[first:last], samples.values[first:last])
