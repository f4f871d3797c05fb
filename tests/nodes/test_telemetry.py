"""The telemetry nodes as processes: a simulated rig shared by two of them, and a bag."""

import signal
import time
from dataclasses import replace

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from ddh_twin_py.nodes.telemetry_publisher import pieces
from ddh_twin_py.sources import registry
from ddh_twin_py.sources.bag import BagSource
from ddh_twin_py.sources.protocol import Samples, SourceError
from ddh_twin_py.telemetry.recording import RigInfo as Rig
from ddh_twin_py.twin.simulated_rig import simulate
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nodes.processes import NodeProcess, stamp_ns, wait_for
from rosgraph_msgs.msg import Clock

from ddh_msgs.msg import DriveTelemetry, HydraulicTelemetry, RigInfo

NS = "/machine"
DUTY = """\
payload_kg: 120.0
repeat: 0
cycle:
  - lift: {speed_rpm: 500, to_m: 0.39}
  - lower: {speed_rpm: 500, to_m: 0.01}
"""


@pytest.fixture(scope="module")
def duty(tmp_path_factory):
    path = tmp_path_factory.mktemp("duty") / "duty.yaml"
    path.write_text(DUTY)
    return path


@pytest.mark.live
def test_two_nodes_publish_one_simulated_rig(listener, duty):
    drive = listener.collect(DriveTelemetry, f"{NS}/drive/telemetry", reliable=False)
    pressures = listener.collect(HydraulicTelemetry, f"{NS}/hydraulics/telemetry", reliable=False)
    rigs = listener.collect(RigInfo, f"{NS}/rig", latched=True)
    given = {"source": "simulation", "simulation__duty": str(duty), "simulation__seed": 7}
    with NodeProcess("pressure_telemetry", NS, **given) as hydraulic, NodeProcess("drive_telemetry", NS, **given) as motor:
        wait_for(lambda: len(drive) > 100 and len(pressures) > 100, 30.0, "telemetry of both")
        motor.stop(signal.SIGINT)
        hydraulic.stop(signal.SIGTERM)
    assert (rigs[0].rig_id, rigs[0].payload_mass) == ("simulated_7", 120.0)
    epoch = stamp_ns(rigs[0])
    chunk = next(iter(simulate(None, duty, 7)))
    for messages, stream, field in ((drive, chunk.drive, "speed"), (pressures, chunk.hydraulic, "pressure_rod_side")):
        truth = dict(zip((stream.stamps(0) + epoch).tolist(), stream.column(field).tolist(), strict=True))
        matched = [(getattr(m, field), truth[stamp_ns(m)]) for m in messages if stamp_ns(m) in truth]
        assert len(matched) > 30
        assert np.array_equal(*np.array(matched).T)


@pytest.mark.live
def test_pressures_wait_for_the_start_of_the_record_and_follow_a_restart(listener, short_bag):
    pressures = listener.collect(HydraulicTelemetry, f"{NS}/hydraulics/telemetry", reliable=False)
    given = {"source": "bag", "bag__path": str(short_bag)}
    with NodeProcess("pressure_telemetry", NS, **given) as hydraulic:
        state = listener.call(GetState, f"{NS}/pressure_telemetry/get_state", GetState.Request(), 30.0)
        assert state.current_state.label == "inactive"
        assert not pressures
        with NodeProcess("drive_telemetry", NS, **given) as motor:
            wait_for(lambda: len(pressures) > 20, 20.0, "pressures")
            assert listener.call(GetState, f"{NS}/pressure_telemetry/get_state", GetState.Request()).current_state.label == "active"
            motor.stop()
        with NodeProcess("drive_telemetry", NS, **given) as motor:
            hydraulic.says("the record was started anew, following", 20.0)
            motor.stop()
        hydraulic.stop()
    assert all(step > 0 for step in np.diff([stamp_ns(m) for m in pressures]))  # a later epoch: no jump back


@pytest.mark.live
def test_a_node_that_was_killed_joins_where_the_record_is(listener, duty):
    namespace = "/joined"
    drive = listener.collect(DriveTelemetry, f"{namespace}/drive/telemetry", reliable=False)
    pressures = listener.collect(HydraulicTelemetry, f"{namespace}/hydraulics/telemetry", reliable=False)
    given = {"source": "simulation", "simulation__duty": str(duty), "simulation__seed": 7, "rate": 3.0}
    with NodeProcess("drive_telemetry", namespace, **given) as motor:
        with NodeProcess("pressure_telemetry", namespace, **given) as hydraulic:
            wait_for(lambda: pressures and stamp_ns(pressures[-1]) - stamp_ns(pressures[0]) > 12e9, 30.0, "pressures")
            hydraulic.process.send_signal(signal.SIGKILL)
            hydraulic.ends()
        before, sent = len(pressures), stamp_ns(drive[-1])
        with NodeProcess("pressure_telemetry", namespace, **given) as hydraulic:
            wait_for(lambda: len(pressures) > before + 200, 30.0, "pressures again")
            hydraulic.stop()
        motor.stop()
    stamps = np.array([stamp_ns(m) for m in pressures[before:]])
    assert stamps.min() > sent
    assert np.all(np.diff(stamps) > 0)


@pytest.mark.live
def test_a_node_that_is_configured_or_activated_later_joins_where_the_record_is(listener, duty):
    namespace = "/led"
    drive = listener.collect(DriveTelemetry, f"{namespace}/drive/telemetry", reliable=False)
    pressures = listener.collect(HydraulicTelemetry, f"{namespace}/hydraulics/telemetry", reliable=False)
    given = {"source": "simulation", "simulation__duty": str(duty), "simulation__seed": 7}

    def change(transition):
        request = ChangeState.Request(transition=Transition(id=transition))
        assert listener.call(ChangeState, f"{namespace}/pressure_telemetry/change_state", request, 60.0).success

    with NodeProcess("pressure_telemetry", namespace, autostart=False, **given) as hydraulic:
        hydraulic.says("ready", 60.0)
        with NodeProcess("drive_telemetry", namespace, **given) as motor:
            wait_for(lambda: drive and stamp_ns(drive[-1]) - stamp_ns(drive[0]) > 8e9, 60.0, "drive telemetry")
            assert not pressures
            change(Transition.TRANSITION_CONFIGURE)
            for number in (1, 2):
                begun, known = len(pressures), stamp_ns(drive[-1])
                change(Transition.TRANSITION_ACTIVATE)
                wait_for(lambda begun=begun: len(pressures) > begun + 50, 30.0, f"pressures, activation {number}")
                assert stamp_ns(pressures[begun]) > known - 4e9, "the backlog is left out"  # a busy computer is late by seconds
                change(Transition.TRANSITION_DEACTIVATE)
                left = stamp_ns(drive[-1])
                wait_for(lambda left=left: stamp_ns(drive[-1]) - left > 8e9, 30.0, "drive telemetry while pressures are inactive")
            change(Transition.TRANSITION_ACTIVATE)
            change(Transition.TRANSITION_ACTIVE_SHUTDOWN)
            left = stamp_ns(drive[-1])
            wait_for(lambda: stamp_ns(drive[-1]) - left > 4e9, 30.0, "drive telemetry after the shutdown of pressures")
            assert stamp_ns(pressures[-1]) < left + 2e9, "a node that is shut down publishes nothing"
            motor.stop()
        hydraulic.stop()


@pytest.mark.live
def test_where_the_clock_is_set_the_record_begins_anew_there(listener, duty):
    drive = listener.collect(DriveTelemetry, "/set/drive/telemetry", reliable=False)
    pressures = listener.collect(HydraulicTelemetry, "/set/hydraulics/telemetry", reliable=False)
    clock = listener.node.create_publisher(Clock, "/clock", 10)
    given = {"source": "simulation", "simulation__duty": str(duty), "simulation__seed": 7, "use_sim_time": True}

    def comes(seconds):
        """Whether, as the clock goes on from so many s, both nodes tell that time."""
        began = time.monotonic()

        def told():
            clock.publish(Clock(clock=Time(sec=seconds + int(time.monotonic() - began))))
            return all(messages and 0.0 <= stamp_ns(messages[-1]) * 1e-9 - seconds < 100.0 for messages in (drive, pressures))

        wait_for(told, 60.0, f"telemetry by a clock that was set to {seconds} s")

    with NodeProcess("drive_telemetry", "/set", **given) as motor, NodeProcess("pressure_telemetry", "/set", **given) as hydraulic:
        motor.says("ready", 60.0)
        hydraulic.says("ready", 60.0)
        for seconds in (100_000, 50_000, 200_000):
            comes(seconds)
        motor.says("this node's clock went back by 50", 10.0)
        motor.stop()
        hydraulic.stop()
    listener.withdraw(clock)


@pytest.mark.live
def test_what_falls_silent_is_named_in_the_log_of_those_that_need_it(duty):
    given = {"source": "simulation", "simulation__duty": str(duty), "simulation__seed": 7}
    with NodeProcess("hydraulic_model", "/silent") as model, NodeProcess("drive_telemetry", "/silent", **given):
        with NodeProcess("pressure_telemetry", "/silent", **given) as hydraulic:
            hydraulic.says("ready", 60.0)
            model.says("rig simulated_7", 60.0)
            time.sleep(3.0)
            hydraulic.stop()
        said = model.says("nothing comes any more on ", 60.0)
        assert "/silent/hydraulics/telemetry" in said and "drive" not in said
        model.stop()


def test_what_a_node_behind_sends_comes_as_if_it_were_in_time():
    due = {"drive/telemetry": np.arange(0.0, 3.0, 0.01), "temperature/ambient": np.arange(0.2, 3.0, 0.5)}
    waiting = {topic: Samples(at, np.rint(at * 1e9).astype(np.int64), at[:, None]) for topic, at in due.items()}
    sent = list(pieces(waiting, 2.005))
    newest = np.maximum.accumulate([samples.due[-1] for _, samples in sent])
    assert all(samples.due[0] >= before - 0.11 for (_, samples), before in zip(sent[1:], newest, strict=False))
    for topic, at in due.items():
        assert np.concatenate([samples.due for name, samples in sent if name == topic]).tolist() == at[at <= 2.005].tolist()
        assert waiting[topic].due.tolist() == at[at > 2.005].tolist()


@pytest.mark.live
def test_without_a_source_it_says_which_there_are():
    with NodeProcess("drive_telemetry", NS) as node:
        assert node.ends() == 2
        assert "parameter source is empty; valid are bag, simulation" in node.text
        assert node.text.count("parameter source is empty") == 1


@pytest.mark.live
def test_a_node_that_waits_and_cannot_be_configured_says_why(listener):
    namespace = "/later"
    with NodeProcess("drive_telemetry", namespace, autostart=False) as node:
        node.says("ready", 60.0)
        request = ChangeState.Request(transition=Transition(id=Transition.TRANSITION_CONFIGURE))
        assert not listener.call(ChangeState, f"{namespace}/drive_telemetry/change_state", request, 20.0).success
        node.says("[ERROR]", 10.0)
        node.stop()
    assert node.text.count("parameter source is empty; valid are bag, simulation") == 1


def test_sources_are_found_by_their_files(tmp_path, monkeypatch):
    (tmp_path / "fieldbus.py").write_text("NAME = 'fieldbus'\nOPTIONS = ()\ndef open_source(options):\n    return 'opened'\n")
    monkeypatch.setattr(registry.sources, "__path__", [*registry.sources.__path__, str(tmp_path)])
    assert list(registry.source_modules()) == ["bag", "fieldbus", "simulation"]
    assert registry.open_source("fieldbus", {}) == "opened"
    with pytest.raises(SourceError, match="no source 'fieldbas'; the nearest is 'fieldbus'"):
        registry.open_source("fieldbas", {})


def test_a_bag_is_due_in_order_of_arrival(short_recording):
    source = BagSource(short_recording)
    batches = list(source.batches(["drive/telemetry", "temperature/ambient"]))
    assert set(batches[0]) == {"drive/telemetry", "temperature/ambient"}
    due = np.concatenate([batch["drive/telemetry"].due for batch in batches])
    stamps = np.concatenate([batch["drive/telemetry"].stamp for batch in batches])
    assert np.array_equal(stamps, short_recording.drive.stamps(short_recording.epoch_ns))
    assert np.all(np.diff(due) >= 0.0)
    assert np.all(due >= (stamps - source.start_ns) * 1e-9 - 1e-9)


def test_a_bag_whose_clock_jumped_goes_on_without_a_pause(short_recording):
    from ddh_twin_py.bags.damage import with_clock_jump

    jumped = with_clock_jump(short_recording, 10.0, -500.0)
    in_order = np.arange(len(jumped.drive))
    at = int(np.argmin(np.diff(jumped.drive.time)))
    late = np.insert(np.delete(in_order, at - 2), at + 5, at - 2)  # it comes after the clock jumped
    for order in (in_order, late):
        drive = replace(jumped.drive, time=jumped.drive.time[order], values=jumped.drive.values[order])
        due = BagSource(replace(jumped, drive=drive))._samples["drive/telemetry"].due
        assert due[-1] == pytest.approx(20.0, abs=0.1)
        assert 0.0 <= np.diff(due).min() and np.diff(due).max() < 0.1


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("bag", {}, "bag.path is empty"),
        ("bag", {"path": "/nowhere"}, "/nowhere does not exist"),
        ("simulation", {}, "simulation.duty is empty"),
        ("simulation", {"duty": "/nowhere.yaml"}, "no such duty file"),
        ("simulation", {"duty": "mixd"}, "mixd: no such duty file, and no duty 'mixd'; the nearest is 'mixed', valid are mixed"),
    ],
)
def test_a_source_that_cannot_be_opened_says_why(name, options, words):
    with pytest.raises(SourceError, match=words):
        registry.open_source(name, options)


def test_a_duty_of_the_project_is_named_as_in_the_verbs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    source = registry.open_source("simulation", {"duty": "mixed", "seed": 3, "duration": 1.0})
    assert "drive/telemetry" in next(iter(source.batches(["drive/telemetry"])))


def test_a_simulated_rig_names_itself(duty):
    source = registry.open_source("simulation", {"duty": str(duty), "seed": 3, "duration": 2.0})
    assert source.rig == Rig("simulated_3", "ISO VG 32", 120.0)
    assert sum(1 for _ in source.batches(["drive/telemetry"])) == 2
    assert source.duration == pytest.approx(2.0, abs=0.02)
