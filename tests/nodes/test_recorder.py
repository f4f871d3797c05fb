"""The recorder as a process."""

import resource
import signal
import time

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.sources.raw_bag import RawBag
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nodes.processes import NodeProcess, wait_for
from std_msgs.msg import String

from ddh_msgs.msg import NodeProgress, RigInfo

pytestmark = pytest.mark.live
NS = "/kept"


@pytest.fixture(scope="module")
def playing(paper_cycle_bag):
    """A bag played at real time, as a machine would publish; longer than any test takes."""
    with NodeProcess("bag_player", NS, bag=str(paper_cycle_bag), wait=0.5) as player:
        player.says("playing at")
        yield player
        player.stop(signal.SIGINT)


def test_patterns_choose_and_nothing_is_overwritten(playing, tmp_path):
    bag = tmp_path / "chosen"
    with NodeProcess("bag_recorder", NS, bag=str(bag), topics=["temperature/*"], exclude=["*/ambient"]) as recorder:
        recorder.says("recording into")
        with NodeProcess("bag_recorder", NS, bag=str(bag)) as second:
            assert second.ends() == 2
            assert "error:" in second.text and str(bag) in second.text
        time.sleep(1.0)
        recorder.stop(signal.SIGINT)
    with NodeProcess("bag_recorder", NS, bag=str(bag), if_exists="number", topics=["rig"]) as third:
        third.says("chosen_2")
        third.stop()
    recording = read_recording(bag)
    assert recording.drive is None and set(recording.temperatures) >= {"tank_oil"} and "ambient" not in recording.temperatures
    assert not any("stopped hard" in finding.message for finding in recording.warnings)


def test_a_killed_recorder_loses_five_seconds_at_most(playing, listener, tmp_path):
    told, topic = listener.collect(NodeProgress, f"{NS}/progress"), f"{NS}/drive/telemetry"

    def taken():
        """Stamps of the drive that the recorder has told to have taken, ns."""
        said = [dict(zip(m.topics, m.newest, strict=True)).get(topic, 0) for m in list(told) if m.node == f"{NS}/bag_recorder"]
        return [stamp for stamp in said if stamp]

    told.clear()  # a recorder of the test before told its own
    with NodeProcess("bag_recorder", NS, bag=str(tmp_path / "bag")) as recorder:
        recorder.says("recording into")
        wait_for(lambda: (at := taken()) and at[-1] - at[0] > 7_000_000_000, 60.0, "seven seconds of the drive")
        recorder.process.kill()
        assert recorder.ends() == -signal.SIGKILL
    recording = read_recording(tmp_path / "bag")
    assert any("the recorder was stopped hard" in finding.message for finding in recording.warnings)
    assert recording.drive.stamps(recording.epoch_ns)[-1] > taken()[-1] - 5_000_000_000
    assert recording.rig.rig_id == "rig_000"
    assert {"ambient", "tank_oil"} <= set(recording.temperatures)


def test_a_recorder_whose_disk_is_full_says_so_and_stays(playing, listener, tmp_path):
    bag, health = tmp_path / "bag", listener.collect(DiagnosticArray, "/diagnostics")
    told = listener.collect(NodeProgress, f"{NS}/progress")
    with NodeProcess("bag_recorder", NS, bag=str(bag)) as recorder:
        recorder.says("recording into")
        wait_for(lambda: bag.exists() and sum(file.stat().st_size for file in bag.iterdir()) > 100_000, 60.0, "some of the bag")
        full = max(file.stat().st_size for file in bag.iterdir()) + 20_000
        resource.prlimit(recorder.process.pid, resource.RLIMIT_FSIZE, (full, full))
        said = recorder.says("nothing is recorded from here on")
        assert f"{bag} cannot be written" in said and "FATAL" not in recorder.text
        del health[:], told[:]
        wait_for(lambda: any(m.node == f"{NS}/bag_recorder" for m in list(told)), 10.0, "its progress, which a player waits for")

        def shown():
            return [s for m in list(health) for s in m.status if s.name == "kept/bag_recorder: recording"]

        wait_for(shown, 10.0, "its health")
        assert all(s.level == DiagnosticStatus.ERROR and "nothing is recorded" in s.message for s in shown())
        recorder.process.terminate()
        assert recorder.ends() == 1 and "Traceback" not in recorder.text and "Exception" not in recorder.text, recorder.text
        told_at_its_end = recorder.text
    recording = read_recording(bag)
    assert recording.drive is not None and len(recording.drive) > 50
    assert f"/drive/telemetry {len(recording.drive)}," in told_at_its_end and "are lost: " in told_at_its_end


def test_a_recorder_that_hears_nothing_of_what_is_published_says_so(listener, tmp_path):
    silent = [listener.node.create_publisher(String, f"/deaf/{name}", 10) for name in ("first", "second")]
    health = listener.collect(DiagnosticArray, "/diagnostics")
    with NodeProcess("bag_recorder", "/deaf", bag=str(tmp_path / "bag")) as recorder:
        recorder.says("2 of 2 topics are published and bring nothing, such as /deaf/first", 60.0)
        wait_for(lambda: any(s.name == "deaf/bag_recorder: recording" and "bring nothing" in s.message
                             for message in list(health) for s in message.status), 10.0, "the same in its health")
        recorder.stop(signal.SIGINT)
    for publisher in silent:
        listener.withdraw(publisher)


def test_what_nobody_stamped_is_recorded_as_it_came(listener, tmp_path):
    bag, begun = tmp_path / "bag", time.time_ns()
    publisher = listener.here(lambda: listener.node.create_publisher(RigInfo, "/unset/rig", 10))
    with NodeProcess("bag_recorder", "/unset", bag=str(bag), topics=["rig"], log_time="stamp") as recorder:
        wait_for(lambda: publisher.get_subscription_count(), 30.0, "the recorder to listen")
        for payload in (100.0, 120.0):
            publisher.publish(RigInfo(payload_mass=payload))
            time.sleep(0.3)
        recorder.stop(signal.SIGINT)
    listener.withdraw(publisher)
    raw = RawBag(bag)
    times = np.concatenate([block.log_time for block in raw.blocks()])
    raw.close()
    assert times.size == 2 and begun < times.min() and raw.duration < 60.0
