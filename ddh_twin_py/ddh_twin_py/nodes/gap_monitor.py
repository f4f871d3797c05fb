"""Node: has a gap opened between machine and free run; and the action that diagnoses recordings."""

from __future__ import annotations

import math
from collections.abc import Mapping
from datetime import UTC, datetime

import numpy as np

from ddh_msgs.msg import GapStatus, ResidualArray, RigInfo, SignalGap, TemperatureEstimateArray
from ddh_twin_py.gap.watch.normal_level import NormalLevelError
from ddh_twin_py.gap.watch.running_test import SignalStatus
from ddh_twin_py.gap.watch.watch import BLUNT, HYDRAULIC, TEMPERATURES, UNITS, GapWatch, Scaled, Settings
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.base.inputs import Inputs
from ddh_twin_py.nodes.base.node_base import TwinNode, run
from ddh_twin_py.nodes.base.parameters import NodeError, Parameter
from ddh_twin_py.nodes.base.progress import Progress
from ddh_twin_py.nodes.base.times import set_time
from ddh_twin_py.nodes.base.twin_parameters import RIG, STALE_AFTER, rig_path
from ddh_twin_py.nodes.feeds.gap_inputs import ESTIMATE_TOPIC, READING_TOPIC, RESIDUAL_TOPIC, Forward, FreeRunResiduals, FreeRunTemperatures
from ddh_twin_py.nodes.messages.conversion import residual_layout
from ddh_twin_py.nodes.player.player_watch import PlayerWatch
from ddh_twin_py.nodes.tasks.diagnose_action import DIAGNOSE_PARAMETERS, DiagnoseAction
from ddh_twin_py.nodes.tasks.health import PAUSED, Health, Report, judge_age, judge_clock, judge_publishers
from ddh_twin_py.nodes.tasks.level_keeper import LevelKeeper
from ddh_twin_py.nodes.tasks.silent_inputs import SilentInputs
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.clocks.clock import Break
from ddh_twin_py.telemetry.signals import RIG_TOPIC
from ddh_twin_py.twin.sensor_errors import sensor_lags

_POLL_PERIOD = 0.1  # s of wall time
_SOURCE = "gap"
_USED = Settings()


class GapMonitorNode(TwinNode):
    """Residuals of the free run to `gap/residuals` and `gap/status`; action `diagnose`."""

    PARAMETERS = (
        RIG,
        Parameter("bin", _USED.bin_length, "Length of a bin of data over which residuals are averaged for the test.", "s", 1.0, 3600.0),
        Parameter(
            "learning", _USED.learning,
            "How much data, counted in bins in which the rod moves, tells what is normal; nothing is tested before. At least 20 bins.",
            "s", 20.0, 31557600.0,
        ),
        Parameter(
            "false_alarm_hours", _USED.between_alarms / 3600.0,
            "Mean time between false alarms of all signals together, in hours of data in which the rod moves.", "h", 1.0, 1e6,
        ),
        Parameter(
            "smallest", _USED.smallest, "Smallest gap that the test is made to find, in multiples of the noise floor.", "1", 0.05, 100.0,
        ),
        Parameter(
            "normal_file", "",
            "File of normal levels: read where it exists (from a commissioning recording, or before a restart), else written once learned.",
        ),
        Parameter(
            "learn_until_end", False,
            "When the node ends, write what it has learned into normal_file also before learning is over: "
            "the data was a reference recording.",
        ),
        STALE_AFTER,
        *DIAGNOSE_PARAMETERS,
    )  # fmt: skip

    def __init__(self) -> None:
        super().__init__("gap_monitor")
        values = self.values
        self._rig = load_rig(rig_path(values["rig"]))
        self._settings = Settings(values["bin"], values["learning"], 3600.0 * values["false_alarm_hours"], values["smallest"])
        self._keeper: LevelKeeper | None = None
        if values["normal_file"]:
            try:
                self._keeper = LevelKeeper(values["normal_file"], values["bin"])
            except NormalLevelError as error:
                raise NodeError(f"parameter normal_file: {error}") from None
        self._rig_id = self._keeper.rig_id if self._keeper else ""
        self._begin_watch()
        self._inputs = Inputs(self)
        self._residuals = self._inputs.add(RESIDUAL_TOPIC, ResidualArray, qos.stream(reliable=True))
        self._estimates = self._inputs.add(ESTIMATE_TOPIC, TemperatureEstimateArray, qos.stream(reliable=True))
        self._readings = self._inputs.add(READING_TOPIC, ResidualArray, qos.stream(reliable=True))
        self._free_temperatures = FreeRunTemperatures(sensor_lags(self._rig), self._rig["tank.top_share"])
        self._parsers = {RESIDUAL_TOPIC: FreeRunResiduals(), READING_TOPIC: self._free_temperatures}
        self._layouts = [residual_layout(_SOURCE, names, ["1"] * len(names))
                         for names in ([name for name, _, _ in HYDRAULIC], TEMPERATURES)]  # fmt: skip
        self._scaled = self.create_publisher(ResidualArray, "gap/residuals", qos.OUTPUT)
        self._told = self.create_publisher(GapStatus, "gap/status", qos.STATUS)
        self.create_subscription(RigInfo, RIG_TOPIC, self._take_rig, qos.LATCHED)
        self._action = DiagnoseAction(self)
        self._player = PlayerWatch(self)
        self._silent = SilentInputs(self, self._player.holds)
        self._health = Health(self)
        for entry in (self._residuals, self._estimates, self._readings):
            self._health.add(entry.topic, lambda report, entry=entry: self._judge_input(report, entry))
        self._health.add("clock", self._judge_clock)
        self._health.add("gap", self._judge_gap)
        self._health.add("diagnosis", self._action.judge)
        self._progress = Progress(self, self._inputs)
        self.waits_for = RESIDUAL_TOPIC, ESTIMATE_TOPIC, READING_TOPIC
        self.every(_POLL_PERIOD, self._poll)

    def _begin_watch(self) -> None:
        self._watch = GapWatch(self._rig, self._settings, self._keeper.of(self._rig_id) if self._keeper else None)
        self._statuses, self._component, self._because = self._watch.status(), "", ""
        self._forward = Forward()

    # --- work --------------------------------------------------------------------------------

    def _poll(self) -> None:
        wall, finished = self.wall(), 0
        takers = (self._watch.take_hydraulics, self._watch.take_temperatures)
        # readings first: what a reading needs that came before it is then among what is taken after it
        readings, residuals, estimates = (self._inputs.take(entry, wall) for entry in (self._readings, self._residuals, self._estimates))
        newest = self._free_temperatures.take_estimates(estimates)
        self._estimates.newest_ns = newest or self._estimates.newest_ns
        inputs = ((self._residuals, residuals), (self._readings, readings))
        for (entry, came), take, layout in zip(inputs, takers, self._layouts, strict=True):
            for stamps, *arrays in self._parsers[entry.topic].parse(came):
                entry.newest_ns = int(stamps[-1])
                resets = self._watch.resets
                if entry is self._residuals:
                    stamps, *arrays = self._beyond(stamps, arrays)
                    if not stamps.size:
                        continue
                scaled, bins = take(stamps, *arrays)
                finished += bins
                self._publish_residuals(layout, scaled)
                if self._watch.resets != resets:
                    self.warn_again(
                        Break.OTHER_TIME, f"the stamps of {entry.name} step back to {stamps[0] * 1e-9:.3f} s; the test begins anew",
                    )
        for source in self._parsers.values():
            for topic, parser in source.parsers.items():
                self._inputs.leave_out(self._inputs.all[topic], parser.unreadable, parser.why)
        if finished:
            self._publish_status()
        self._progress.tell(wall)

    def _beyond(self, stamps: np.ndarray, arrays: list[np.ndarray]) -> list[np.ndarray]:
        """Stamps and arrays without what comes again by a clock that was put back a little."""
        before = self._forward.put_back
        used = self._forward.used(stamps)
        if self._forward.put_back != before:
            self.warn_again(Break.PUT_BACK, f"the stamps of {self._residuals.name} step back to {stamps[~used][0] * 1e-9:.3f} s; the test "
                            "goes on where they are past what it heard")
        return [array[used] for array in (stamps, *arrays)]

    def _publish_residuals(self, layout, scaled: Scaled) -> None:
        some = np.isfinite(scaled.residual).any(axis=1)
        values = {
            "residuals.measured": scaled.measured[some], "residuals.predicted": scaled.expected[some],
            "residuals.residual": scaled.residual[some], "residuals.standard_deviation": scaled.noise[some],
        }  # fmt: skip
        for message in layout.compose(scaled.stamp_ns[some], values):
            self._scaled.publish(message)

    def _publish_status(self) -> None:
        before = {status.signal for status in self._statuses if status.opened}
        self._statuses = self._watch.status()
        self._component, self._because = self._watch.component(self._statuses)
        for status in self._statuses:
            if status.opened and status.signal not in before:
                self.get_logger().warning(f"a gap has opened: {_words(status)}")
            elif status.signal in before and not status.opened:
                self.get_logger().info(f"the gap of {status.signal} has closed")
        message = GapStatus(
            watching=any(status.tested for status in self._statuses),
            opened=any(status.opened for status in self._statuses), component=self._component, because=self._because,
            bin=self._settings.bin_length, time_between_false_alarms=self._settings.between_alarms,
            signals=[_signal_gap(status) for status in self._statuses],
        )  # fmt: skip
        set_time(message.header.stamp, self._watch.newest_end_ns)
        self._told.publish(message)
        if self._keeper is not None:
            self._keeper.keep(self._rig_id, self._watch.levels)

    def _take_rig(self, message: RigInfo) -> None:
        self._health.hardware_id = message.rig_id
        if not message.rig_id or message.rig_id == self._rig_id:
            return
        if self._rig_id:
            self.get_logger().warning(f"rig {message.rig_id!r} was announced, this was {self._rig_id!r}; what is normal is learned anew")
            self._rig_id = message.rig_id
            self._begin_watch()
        self._rig_id = message.rig_id

    def close(self) -> None:
        self._action.close()
        if self._keeper is not None:
            if self.values["learn_until_end"]:
                self._watch.end_learning()
                self._keeper.keep(self._rig_id, self._watch.levels)
                if not self._watch.levels:
                    self.get_logger().warning(f"{self._keeper.path}: not written; too little was heard to learn what is normal, at least "
                                              f"20 bins of {self._settings.bin_length:g} s in which the rod moves are needed")
            elif not self._watch.levels:
                self.get_logger().info(f"{self._keeper.path}: not written; what is normal was still being learned, and learn_until_end is "
                                       "off")
            self._keeper.close()
            if self._keeper.failure:
                self.get_logger().error(self._keeper.failure)

    # --- health ------------------------------------------------------------------------------

    def _judge_input(self, report: Report, entry) -> str:
        wall = self.wall()
        paused = self._player.paused(wall)
        limit = math.inf if paused else self.values["stale_after"]
        self._silent.note(entry.name, *judge_age(report, entry, wall, limit, required=False), wall)
        judge_publishers(report, entry, self)
        report.add("messages", entry.received, "1")
        return PAUSED if paused else "comes in" if entry.received else "nothing yet"

    def _judge_clock(self, report: Report) -> str:
        resets, kept = self._watch.resets, self._forward.put_back
        return judge_clock(report, resets + kept, {Break.OTHER_TIME: resets, Break.PUT_BACK: kept})

    def _judge_gap(self, report: Report) -> str:
        report.add("mean time between false alarms", self._settings.between_alarms / 3600.0, "h")
        report.add("bin", self._settings.bin_length, "s")
        report.add("component", self._component or "not told", "")
        if self._keeper is not None and self._keeper.failure:
            report.error(self._keeper.failure)
        tested = 0
        for status in self._statuses:
            unit, tested = UNITS[status.signal], tested + status.tested
            report.add(f"{status.signal} learned", status.learned, "1")
            report.add(f"{status.signal} noise floor", status.floor, unit)
            report.add(f"{status.signal} smallest gap", status.detectable, unit)
            report.add(f"{status.signal} statistic", status.statistic, "1")
            report.add(f"{status.signal} threshold", status.threshold, "1")
            report.add(f"{status.signal} size", status.size, unit)
            if status.opened:
                report.warn(_words(status))
            elif status.unheard and math.isfinite(status.threshold):
                report.warn(f"{status.signal} is not tested: too little of it was heard in {status.unheard:g} s of work")
        if self._component:
            report.warn(f"points to {self._component}: {self._because}")
        if not tested:
            share = max(status.learned for status in self._statuses)
            return f"learns what is normal, {100.0 * share:.0f} % of {self._settings.learning:g} s"
        blunt = self._watch.blunt()
        if blunt:
            report.warn(_blunt_words(blunt, tested))
        return f"no gap in {tested} signals"


def _blunt_words(blunt: Mapping[str, float], tested: int) -> str:
    worst, times = next(iter(blunt.items()))
    return (f"a small gap stays hidden: {len(blunt)} of {tested} signals have a noise floor of {BLUNT:g} times the sensor's noise or more, "
            f"{worst} {times:.0f} times; the rig file does not fit this rig, ddh-twin calibrate makes one that does")


def _words(status: SignalStatus) -> str:
    since, unit = datetime.fromtimestamp(status.since, UTC), UNITS[status.signal]
    return (
        f"{status.signal} departs by {status.size:.3g} +- {status.size_deviation:.2g} {unit}, {abs(status.size) / status.floor:.2g} times "
        f"its noise floor, since {since:%Y-%m-%d %H:%M:%S} UTC"
    )


def _signal_gap(status: SignalStatus) -> SignalGap:
    row = SignalGap(
        signal=status.signal, unit=UNITS[status.signal], tested=status.tested, learned=status.learned,
        floor=status.floor, statistic=status.statistic, threshold=status.threshold, opened=status.opened, size=status.size,
        size_standard_deviation=status.size_deviation, size_in_floors=status.size / status.floor,
    )  # fmt: skip
    if status.opened:
        set_time(row.since, round(status.since * 1e9))
    return row


def main(args: list[str] | None = None) -> int:
    return run(GapMonitorNode, args)
