"""gap_monitor as a process: the running test on the models' topics, and the action with a stand-in for the diagnosis."""

import json
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from action_msgs.srv import CancelGoal
from ddh_twin_py.estimation.sensors import NODE_OF_SENSOR
from ddh_twin_py.gap.watch.normal_level import load_levels
from ddh_twin_py.nodes.base import qos
from ddh_twin_py.nodes.messages.conversion import estimate_layout, hydraulic_residual_layout, residual_layout
from ddh_twin_py.nodes.tasks.diagnose_action import SAYS_AGAIN
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.hydraulic_model import RESIDUAL_SIGNALS
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nodes.processes import NodeProcess, runs, wait_for
from rclpy.action import ActionClient

from ddh_msgs.action import DiagnoseGap
from ddh_msgs.msg import GapStatus, PlayerStatus, ResidualArray, RigInfo, TemperatureEstimateArray

pytestmark = pytest.mark.live
TICK = 50_000_000
MEETING = 1_000_000_000_000  # ns, beyond all that is tested
FAKE = [sys.executable, str(Path(__file__).parents[1] / "support" / "fake_diagnosis.py")]
SHORT = {"bin": 1.0, "learning": 40.0, "diagnosis_command": FAKE}


class Models:
    """Publishes what hydraulic_model and temperature_fusion would, for a rig that lifts and lowers."""

    def __init__(self, listener, namespace):
        node = listener.node
        self._begin(0)
        topics = {"hydraulics/residuals": ResidualArray, "temperature/estimates": TemperatureEstimateArray,
                  "temperature/residuals": ResidualArray}  # fmt: skip
        profile = qos.stream(reliable=True)
        self._publishers = [node.create_publisher(kind, f"{namespace}/{topic}", profile) for topic, kind in topics.items()]
        self._health = listener.collect(DiagnosticArray, "/diagnostics")
        self._inputs = {f"{namespace[1:]}/gap_monitor: {topic}" for topic in topics}
        self._layouts = [hydraulic_residual_layout("soft_sensor"), hydraulic_residual_layout("free_run")]
        self._estimates = estimate_layout()
        names = [f"temperature/{sensor}" for sensor in NODE_OF_SENSOR]
        self._readings = residual_layout("fusion", names, ["degC"] * len(names))
        sensors = load_rig(None).sensors
        self._noise = np.array([sensors[key].noise for _, key, _ in RESIDUAL_SIGNALS])

    def _begin(self, at):
        self.rng, self.at = np.random.default_rng(4), at

    def meet_and_begin(self):
        """Meet the node far ahead and step back: its test begins anew, and all that is published from here on counts."""
        self._begin(MEETING)
        self.meet()
        self._begin(0)

    def meet(self):
        """Publish half seconds until the node says that it hears all topics: each side learns of the other in its own time."""
        self._health.clear()

        def hears():
            self.run(0.5)
            time.sleep(0.5)
            said = [status for message in list(self._health) for status in message.status if status.name in self._inputs]
            heard = {status.name for status in said if any(v.key == "messages [1]" and int(v.value) > 0 for v in status.values)}
            return heard == self._inputs

        wait_for(hears, 60.0, "the node hears every topic")

    def run(self, seconds, departs=0.0):
        """Publish so much data; by 2 s, as the node leaves out readings that it meets before the free run of their time."""
        for begin in np.arange(0.0, seconds, 2.0):
            self._run(min(2.0, seconds - begin), departs)

    def _run(self, seconds, departs):
        n = round(seconds / 0.05)
        stamps = self.at + TICK * np.arange(1, n + 1)
        self.at = int(stamps[-1])
        names = [name for name, _, _ in RESIDUAL_SIGNALS]
        measured = self._noise * self.rng.standard_normal((n, len(names)))
        measured[:, names.index("rod_velocity")] += np.where((stamps // (8 * TICK)) % 2 == 0, 0.05, -0.05)
        predicted = np.zeros_like(measured)
        predicted[:, names.index("rod_velocity")] = np.where((stamps // (8 * TICK)) % 2 == 0, 0.05, -0.05)
        measured[:, names.index("pressure_piston_side")] += departs
        values = {"residuals.measured": measured, "residuals.predicted": predicted, "residuals.residual": measured - predicted}
        for layout, factor in zip(self._layouts, (1e3, 1.0), strict=True):  # the soft sensor's must not be looked at
            self._send(0, layout.compose(stamps, {**values, "residuals.measured": factor * measured}))
        self._send(1, self._estimates.compose(stamps, {"estimates.predicted": np.full((n, len(NODES)), 39.0)}))
        read = stamps[stamps // TICK % 10 == 0]
        self._send(2, self._readings.compose(read, {"residuals.measured": 40.0 + 0.1 * self.rng.standard_normal((read.size, 9))}))

    def _send(self, number, messages):
        for first in range(0, len(messages), 100):
            for message in messages[first : first + 100]:
                self._publishers[number].publish(message)
            time.sleep(0.02)


def newest(statuses, stamp_s):
    """The newest status, once it is of this time of data."""
    after = range(stamp_s, MEETING // 10**9)
    return wait_for(lambda: statuses and statuses[-1].header.stamp.sec in after and statuses[-1], 30.0, f"status of {stamp_s} s")


def test_a_gap_opens_is_told_and_its_normal_levels_survive(listener, tmp_path):
    space, file = "/watch", tmp_path / "normal.json"
    statuses = listener.collect(GapStatus, f"{space}/gap/status", latched=True)
    residuals = listener.collect(ResidualArray, f"{space}/gap/residuals")
    health = listener.collect(DiagnosticArray, "/diagnostics")
    announce = listener.node.create_publisher(RigInfo, f"{space}/rig", qos.LATCHED)
    announce.publish(RigInfo(rig_id="rig_7", oil_grade="ISO VG 32", payload_mass=149.5))
    with NodeProcess("gap_monitor", space, normal_file=str(file), **SHORT) as node:
        models = Models(listener, space)
        models.meet_and_begin()
        models.run(30.0)
        status = newest(statuses, 28)
        assert not status.watching and not status.opened and status.signals[0].learned == pytest.approx(0.7, abs=0.05)
        models.run(30.0)
        models.run(30.0)
        status = newest(statuses, 88)
        assert status.watching and not status.opened and status.component == "" and status.time_between_false_alarms == 3.6e6
        assert {row.signal for row in status.signals if row.tested} >= {"current", "pressure_rod_side", "temperature/tank_oil"}
        models.run(40.0, departs=5e5)
        status = newest(statuses, 128)
        rows = {row.signal: row for row in status.signals}
        assert status.opened and [name for name, row in rows.items() if row.opened] == ["pressure_piston_side"]
        row = rows["pressure_piston_side"]
        assert row.unit == "Pa" and row.size == pytest.approx(5e5, rel=0.05) and row.statistic > row.threshold
        assert row.since.sec == pytest.approx(90, abs=2) and row.size_in_floors == pytest.approx(row.size / row.floor)
        assert status.component == "sensor" and "a real one would move current" in status.because
        node.says("a gap has opened: pressure_piston_side departs by 5")

        def warned():
            found = {s.name: s for message in health for s in message.status if s.name.startswith("watch/gap_monitor")}
            status = found.get("watch/gap_monitor: gap")
            return status if status and status.level == DiagnosticStatus.WARN else None

        said = wait_for(warned, 10.0, "a warning")
        assert "points to sensor" in said.message and "times its noise floor, since 1970-01-01 00:01:" in said.message
        assert {"pressure_piston_side size [Pa]", "mean time between false alarms [h]"} <= {entry.key for entry in said.values}
        assert said.hardware_id == "rig_7"
        last = residuals[-1]
        shown = {r.signal: r for r in residuals[-2].residuals} | {r.signal: r for r in last.residuals}
        assert last.source == "gap" and all(r.unit == "1" for r in shown.values())
        node.stop()
    rig_id, levels = load_levels(file, 1.0)
    assert rig_id == "rig_7" and set(levels) >= {"current", "temperature/tank_oil"}
    assert len([name for name in levels if name.startswith("temperature/")]) == len(NODE_OF_SENSOR)

    statuses.clear()
    with NodeProcess("gap_monitor", space, normal_file=str(file), **SHORT) as node:
        models.at += 60_000_000_000
        models.meet()
        models.run(5.0)
        assert newest(statuses, models.at // 10**9 - 2).watching
        announce.publish(RigInfo(rig_id="rig_8"))
        node.says("rig 'rig_8' was announced, this was 'rig_7'; what is normal is learned anew")
        models.run(5.0)
        status = newest(statuses, models.at // 10**9 - 2)
        assert not status.watching
        models.at = 20_000_000_000
        models.run(3.0)
        node.says("the test begins anew")
        node.stop()
    assert load_levels(file, 1.0)[0] == "rig_7"


def test_what_a_paused_player_holds_is_not_missed(listener):
    space = "/held_watch"
    health = listener.collect(DiagnosticArray, "/diagnostics")
    player = listener.node.create_publisher(PlayerStatus, f"{space}/bag_player/status", qos.LATCHED)

    def told(words, level):
        said = [s for message in list(health) for s in message.status if s.name == "held_watch/gap_monitor: hydraulics/residuals"]
        return said and words in said[-1].message and said[-1].level == level

    def paused():
        player.publish(PlayerStatus(paused=True))
        time.sleep(0.5)
        return told("the player is paused", DiagnosticStatus.OK)

    with NodeProcess("gap_monitor", space, stale_after=0.5, **SHORT) as node:
        Models(listener, space).meet()
        wait_for(lambda: told("stale", DiagnosticStatus.WARN), 20.0, "the input to be missed")
        wait_for(paused, 20.0, "the pause to be known")
        wait_for(lambda: told("stale", DiagnosticStatus.WARN), 20.0, "the player to be gone")
        node.stop()


def test_a_file_of_normal_levels_that_cannot_be_used_ends_the_node(tmp_path):
    (tmp_path / "normal.json").write_text("{}")
    with NodeProcess("gap_monitor", "/refused", normal_file=str(tmp_path / "normal.json")) as node:
        assert node.ends() == 2
        assert "parameter normal_file" in node.text and "is no file of normal levels" in node.text


class Client:
    """Sends goals to `diagnose` and gathers what comes back."""

    def __init__(self, listener, namespace):
        self._listener = listener
        self.client = ActionClient(listener.node, DiagnoseGap, f"{namespace}/diagnose")
        assert self.client.wait_for_server(30.0)
        self.feedback = []

    def send(self, path, **more):
        goal = DiagnoseGap.Goal(field=[str(path)], **more)
        future = self._listener.here(
            lambda: self.client.send_goal_async(goal, feedback_callback=lambda m: self.feedback.append(m.feedback)))
        wait_for(future.done, 20.0, "the goal's answer")
        assert future.result().accepted
        return future.result()

    def result(self, handle):
        future = self._listener.here(handle.get_result_async)
        wait_for(future.done, 30.0, "the result")
        return future.result().status, future.result().result


SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


def stand_in(node):
    """Process id of the stand-in for the diagnosis that a node has started, None where there is none; other tests have theirs."""
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_text().split("\0")
            parent = (entry / "stat").read_text().rpartition(")")[2].split()[1]
            if FAKE[1] in words and int(parent) == node.process.pid and runs(int(entry.name)):
                return int(entry.name)
        except OSError:
            continue
    return None


def test_the_action_diagnoses_cancels_refuses_and_leaves_nothing_behind(listener, tmp_path):
    space = f"/asked_{time.monotonic_ns()}"  # run again, it must not find the server of the node that has just ended
    for name in ("well", "slow", "bad", "crash"):
        (tmp_path / name / "field").mkdir(parents=True)
    with NodeProcess("gap_monitor", space, **SHORT) as node:
        client = Client(listener, space)
        status, result = client.result(client.send(tmp_path / "well", rig=""))
        assert status == SUCCEEDED and result.success and result.verdict == "explained" and result.message == ""
        asked = json.loads(result.report)["asked"]
        assert asked["field"] == [str(tmp_path / "well" / "field")] and asked["nice"] == 10 and result.sentence.startswith("Pump 1")

        for name, words in (("bad", "drive/telemetry: no message"), ("crash", "signal SIGKILL"), ("nowhere", "nowhere does not exist"),
                            ("x" * 100_000, "(100"), ("x" * 300, "File name too long")):
            status, result = client.result(client.send(tmp_path / name))
            assert status == ABORTED and not result.success and words in result.message and result.report == ""

        for given, words in (("", "none empty"), ("here/field", "where the node runs"), ("here/field\n", "'here/field\\n' does not exist")):
            status, result = client.result(client.send(given))
            assert status == ABORTED and words in result.message and "\n" not in result.message
        status, result = client.result(client.send(tmp_path / "well", rig="y" * 5000))
        assert status == ABORTED and "rig file yyy" in result.message and "(5000 characters)" in result.message

        client.feedback.clear()
        asked_at = time.monotonic()
        slow = client.send(tmp_path / "slow")
        wait_for(lambda: any(f.done == 0.5 and f.stage == "fitting" for f in client.feedback), 20.0, "feedback")
        status, result = client.result(client.send(tmp_path / "well"))
        assert status == ABORTED and "slow/field is under way (50 %)" in result.message
        assert f"ros2 service call {space}/diagnose/_action/cancel_goal" in result.message
        status, result = client.result(client.send(tmp_path / "nowhere"))
        assert status == ABORTED and "nowhere does not exist" in result.message
        time.sleep(1.5)
        told = [(f.done, f.stage) for f in client.feedback]
        again = (time.monotonic() - asked_at) // SAYS_AGAIN
        assert len(set(told)) <= len(told) <= len(set(told)) + again, "what has not changed is told again seldom"
        pid = stand_in(node)
        assert pid is not None
        wait_for(slow.cancel_goal_async().done, 20.0, "the cancelling")
        status, result = client.result(slow)
        assert status == CANCELED and result.message == "the diagnosis was stopped" and not runs(pid)

        orphan = client.send(tmp_path / "slow")
        pid = wait_for(lambda: stand_in(node), 20.0, "the process")
        answer = listener.call(CancelGoal, f"{space}/diagnose/_action/cancel_goal", CancelGoal.Request())  # by one who did not ask for it
        assert len(answer.goals_canceling) == 1
        assert client.result(orphan)[0] == CANCELED and not runs(pid)

        last = listener.here(client.send(tmp_path / "slow").get_result_async)
        pid = wait_for(lambda: stand_in(node), 20.0, "the process")
        node.stop()
        assert not runs(pid)
        wait_for(last.done, 20.0, "the end of the node to be told")
        assert last.result().status == ABORTED and "the node ends before the diagnosis" in last.result().result.message
    client.client.destroy()
