"""The player as a process: services, pace, waiting, and what it says of a bag that it cannot play."""

import time

import numpy as np
import pytest
from ddh_twin_py.bags.damage import truncate
from ddh_twin_py.bags.writer import write_recording
from nodes.processes import NodeProcess, stamp_ns, wait_for
from rosgraph_msgs.msg import Clock
from std_srvs.srv import SetBool

from ddh_msgs.msg import DriveTelemetry, NodeProgress, PlayerStatus, RigInfo
from ddh_msgs.srv import Seek, SetRate

pytestmark = pytest.mark.live
EPOCH = 1_772_000_000_000_000_000
NS = "/played"


@pytest.fixture(scope="module")
def drive(listener):
    return listener.collect(DriveTelemetry, f"{NS}/drive/telemetry")


def seconds(messages):
    return [(stamp_ns(m) - EPOCH) * 1e-9 for m in list(messages)]


def clock_times(clock):
    return [m.clock.sec + m.clock.nanosec * 1e-9 - EPOCH * 1e-9 for m in list(clock)] or [0.0]


def test_services_pause_seek_and_rate(short_bag, listener, drive):
    clock = listener.collect(Clock, "/clock", reliable=False)
    drive.clear()
    with NodeProcess("bag_player", NS, bag=str(short_bag), paused=True, exit_at_end=False, start_offset=2.0) as player:
        player.says("playing at 1 times real time")
        time.sleep(0.2)
        assert not drive
        assert listener.call(SetBool, f"{NS}/bag_player/pause", SetBool.Request(data=False)).success
        wait_for(lambda: len(drive) > 40, 5.0, "messages")
        assert seconds(drive)[0] == pytest.approx(2.0, abs=0.03)

        assert listener.call(SetBool, f"{NS}/bag_player/pause", SetBool.Request(data=True)).success
        time.sleep(0.2)
        count = len(drive)
        time.sleep(0.2)
        assert len(drive) == count  # paused is paused

        refused = listener.call(Seek, f"{NS}/bag_player/seek", Seek.Request(offset=99.0))
        assert not refused.success and "allowed are 0 to 20.0" in refused.message
        assert listener.call(Seek, f"{NS}/bag_player/seek", Seek.Request(offset=10.0)).success
        refused = listener.call(SetRate, f"{NS}/bag_player/set_rate", SetRate.Request(rate=-1.0))
        assert not refused.success and "rate is -1" in refused.message
        assert listener.call(SetRate, f"{NS}/bag_player/set_rate", SetRate.Request(rate=4.0)).success
        drive.clear()
        started = time.monotonic()
        listener.call(SetBool, f"{NS}/bag_player/pause", SetBool.Request(data=False))
        wait_for(lambda: drive and seconds(drive)[-1] > 14.0, 5.0, "four seconds of data")
        assert seconds(drive)[0] == pytest.approx(10.0, abs=0.03)
        assert time.monotonic() - started > 0.8

        listener.call(Seek, f"{NS}/bag_player/seek", Seek.Request(offset=1.0))  # back, while it plays
        drive.clear()
        wait_for(lambda: drive and seconds(drive)[-1] < 9.0, 3.0, "stamps that jumped back")
        listener.call(SetRate, f"{NS}/bag_player/set_rate", SetRate.Request(rate=0.0))
        player.says("end of the bag", 10.0)
        wait_for(lambda: seconds(drive)[-1] > 19.95, 5.0, "the last message")
        wait_for(lambda: clock_times(clock)[-1] == pytest.approx(20.0, abs=0.1), 5.0, "the clock at the end")
        assert player.process.poll() is None  # exit_at_end is false
        player.stop()
    assert min(clock_times(clock)) < 3.0


def test_the_status_follows_and_the_end_is_not_the_end(short_bag, listener, drive):
    status = listener.collect(PlayerStatus, f"{NS}/bag_player/status", latched=True)
    drive.clear()
    with NodeProcess("bag_player", NS, bag=str(short_bag), rate=0.0, exit_at_end=False, start_offset=18.0) as player:
        player.says("end of the bag")
        last = wait_for(lambda: status and status[-1].ended and status[-1], 5.0, "the status of the end")
        assert (last.bag, last.rate, last.paused, last.loop, last.waiting) == (str(short_bag), 0.0, False, False, False)
        assert last.position == pytest.approx(20.0, abs=0.1) and last.duration == pytest.approx(20.0, abs=0.1)
        drive.clear()
        listener.call(SetRate, f"{NS}/bag_player/set_rate", SetRate.Request(rate=2.0))
        assert listener.call(Seek, f"{NS}/bag_player/seek", Seek.Request(offset=5.0)).success
        moving = wait_for(lambda: not status[-1].ended and status[-1].position > 7.0 and status[-1], 5.0, "a position that moves on")
        assert moving.rate == 2.0 and 0.5 < moving.speed < 4.0
        sought = [at for at in seconds(drive) if at < 18.0]  # what was sent before the seek may still have come after the list was cleared
        assert sought[0] == pytest.approx(5.0, abs=0.03)
        listener.call(SetBool, f"{NS}/bag_player/pause", SetBool.Request(data=True))
        wait_for(lambda: status[-1].paused, 5.0, "the status of the pause")
        assert player.text.count("end of the bag") == 1
        player.stop()


def test_the_pace_is_that_of_a_slow_listener_and_nothing_is_lost(short_bag, listener, drive, short_recording):
    """A listener that takes 20 s of data in about 4 s of wall time, and tells how far it is."""
    publisher = listener.node.create_publisher(NodeProgress, f"{NS}/progress", 10)
    topic = f"{NS}/drive/telemetry"
    drive.clear()
    taken, ahead = 0, []
    with NodeProcess("bag_player", NS, bag=str(short_bag), rate=0.0, lead=0.5, wait_for_nodes=["/test_listener"]) as player:
        while player.process.poll() is None:
            time.sleep(0.05)
            taken = min(taken + 25, len(drive))
            newest = stamp_ns(drive[taken - 1]) if taken else 0
            ahead.append((stamp_ns(drive[-1]) - newest) * 1e-9 if taken else 0.0)
            publisher.publish(NodeProgress(node="/test_listener", topics=[topic], newest=[newest]))
        assert player.ends() == 0, player.text
    assert len(drive) == len(short_recording.drive)
    assert 0.2 < max(ahead) < 1.1  # lead, and what was on its way
    listener.withdraw(publisher)


def test_a_node_that_runs_and_is_not_ready_is_waited_for_and_said(short_bag, listener, drive):
    publisher = listener.node.create_publisher(NodeProgress, f"{NS}/progress", 10)
    given = {"bag": str(short_bag), "rate": 0.0, "wait": 0.5, "wait_for_nodes": ["/test_listener"]}
    with NodeProcess("bag_player", NS, **given) as player:
        said = player.says("node /test_listener is there and not ready yet", 20.0)
        assert "waiting for up to 900.5 s" in said and "playing at" not in player.text
        wait_for(lambda: publisher.get_subscription_count(), 10.0, "the player to listen")
        publisher.publish(NodeProgress(node="/test_listener", topics=[], newest=[]))
        assert player.ends() == 0, player.text
        assert player.text.count("not ready yet") == 1
    listener.withdraw(publisher)


def test_loop_begins_again_and_the_rig_is_told_once(short_bag, listener, drive):
    rig = listener.collect(RigInfo, f"{NS}/rig", latched=True)
    drive.clear()
    with NodeProcess("bag_player", NS, bag=str(short_bag), rate=0.0, loop=True, topics=["drive/*", "rig"]) as player:
        player.says("round 3")
        wait_for(lambda: (np.diff(seconds(drive)) < -19.0).sum() >= 2, 20.0, "the second step back")
        player.stop()
    steps = np.diff(seconds(drive))
    assert (steps < -19.0).sum() >= 2
    assert [message.rig_id for message in rig] == ["rig_000"]


def test_a_bag_without_an_end_is_played_as_far_as_it_goes(short_recording, tmp_path, listener):
    bag, alone = write_recording(tmp_path / "cut", short_recording), f"{NS}/cut"  # where no round of another test still comes in
    truncate(bag, 0.4)
    heard = listener.collect(DriveTelemetry, f"{alone}/drive/telemetry")
    with NodeProcess("bag_player", alone, bag=str(bag), rate=0.0) as player:
        assert player.ends() == 0
        assert "has no end" in player.text
    wait_for(lambda: len(heard) > 0.1 * len(short_recording.drive), 10.0, "what was played")  # a busy listener is behind
    assert len(heard) < 0.9 * len(short_recording.drive)


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"bag": "/nowhere"}, "/nowhere does not exist"),
        ({"bag": "SHORT", "start_offset": 50.0}, "start_offset is 50 s"),
        ({"bag": "SHORT", "topics": ["nothing/*"]}, "no topic of"),
        ({"bag": "SHORT", "rate": 3}, "parameter rate is 3, it must be of type double and 0 to 10000; write 3.0"),
    ],
    ids=["no bag", "offset", "topics", "type"],
)
def test_what_cannot_be_used_is_said_in_one_line(parameters, words, short_bag):
    given = {name: str(short_bag) if value == "SHORT" else value for name, value in parameters.items()}
    with NodeProcess("bag_player", NS, **given) as player:
        assert player.ends() == 2
        errors = [line for line in player.lines if line.startswith("error: ")]
        assert len(errors) == 1 and words in errors[0], player.text
        assert "Traceback" not in player.text


def test_a_mistyped_parameter_is_told(short_bag):
    with NodeProcess("bag_player", NS, bag=str(short_bag), strat_offset=1.0) as player:
        player.says("there is no parameter strat_offset, it is ignored; nearest is start_offset")
        player.stop()
