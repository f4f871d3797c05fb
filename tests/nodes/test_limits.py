"""The look-ahead on the live graph: topic, service, warnings before the limit."""

import math
import time

import pytest
from ddh_twin_py.physics.thermal_network import NODES
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nodes.processes import NodeProcess, wait_for
from support.simulated import DUTY

from ddh_msgs.msg import LimitPrediction
from ddh_msgs.srv import PredictLimits

pytestmark = pytest.mark.live
MODELS = ("hydraulic_model", "machine_thermal", "temperature_fusion")
SPACE = "/watched"


@pytest.fixture(scope="module")
def watched(short_bag, listener):
    """The twin after the short bag, with a winding limit that the paper's duty will break in minutes."""
    limits, health = listener.collect(LimitPrediction, f"{SPACE}/temperature/limits"), listener.collect(DiagnosticArray, "/diagnostics")
    limit = {"temperature_fusion": {"winding_limit": 45.0}}
    nodes = [NodeProcess(name, SPACE, flush_after=0.5, **limit.get(name, {})) for name in MODELS]
    with NodeProcess("bag_player", SPACE, bag=str(short_bag), rate=0.0, wait_for_nodes=list(MODELS)) as player:
        assert player.ends() == 0, player.text
    time.sleep(2.0)
    yield limits, health
    for node in nodes:
        with node:
            node.stop()


def test_the_topic_tells_all_limits(watched):
    limits, _ = watched
    last = wait_for(lambda: limits and limits[-1], 10.0, "limits")
    assert last.duty_known and last.rms_current > 1.0 and last.mean_absolute_speed > 5.0 and last.horizon == 3600.0
    rows = {row.location: row for row in last.limits}
    assert set(rows) == {"winding_hot_spot", "oil", "seals"}
    winding, oil = rows["winding_hot_spot"], rows["oil"]
    assert winding.limit == pytest.approx(45.0) and winding.temperature < 45.0 and winding.standard_deviation > 0.0
    assert winding.time_to_limit_16 <= winding.time_to_limit <= winding.time_to_limit_84 < 3600.0
    assert 0.0 < winding.allowed_current < last.rms_current and 0.0 <= winding.allowed_speed < last.mean_absolute_speed
    assert oil.limit == pytest.approx(80.0) and oil.time_to_limit > 600.0


def test_the_warning_comes_before_the_limit_with_what_would_keep_it(watched):
    _, health = watched

    def warned():
        for message in reversed(health):
            for status in message.status:
                if status.name == "watched/temperature_fusion: limits" and status.level != DiagnosticStatus.OK:
                    return status
        return None

    status = wait_for(warned, 10.0, "a warning")
    assert status.level == DiagnosticStatus.WARN
    assert "winding_hot_spot reaches 45 degC in" in status.message and "A rms" in status.message
    keys = {entry.key for entry in status.values}
    assert {"winding_hot_spot time to limit [s]", "winding_hot_spot allowed current [A]", "oil limit [degC]"} <= keys


def ask(listener, **fields):
    return listener.call(PredictLimits, f"{SPACE}/predict_limits", PredictLimits.Request(**fields), 30.0)


def test_the_service_answers_for_present_rest_and_given(watched, listener):
    request = PredictLimits.Request
    present, rest = ask(listener, duty=request.PRESENT), ask(listener, duty=request.REST, horizon=600.0)
    hard = ask(listener, duty=request.GIVEN, rms_current=15.0)
    text = (DUTY / "paper_cycle.yaml").read_text()
    given = ask(listener, duty=request.GIVEN, duty_file=text.replace("speed_rpm: 500", "speed_rpm: 250"), horizon=1200.0)
    for answer in (present, rest, hard, given):
        assert answer.success, answer.message
        assert list(answer.locations) == [*NODES, "winding_hot_spot"]
        assert len(answer.temperature) == len(answer.standard_deviation) == len(answer.time) * len(answer.locations)
    time_of = {name: answer.limits[0].time_to_limit for name, answer in (("present", present), ("rest", rest), ("hard", hard))}
    assert time_of["hard"] < time_of["present"] < math.inf and time_of["rest"] == math.inf
    assert rest.time[-1] == 600.0 and given.time[-1] == 1200.0 and hard.rms_current == pytest.approx(15.0)
    assert "cycle" in given.message and given.rms_current > 1.0


def test_a_question_that_cannot_be_answered_says_why(watched, listener):
    request = PredictLimits.Request
    for fields, words in (
        ({"duty": 7}, "allowed are 0"),
        ({"duty": request.GIVEN, "duty_file": "cycle: nothing"}, "a list of segments"),
        ({"duty": request.REST, "horizon": 1e9}, "horizon"),
        ({"duty": request.GIVEN, "rms_current": -1.0}, "rms_current"),
        ({"duty": request.GIVEN, "mean_absolute_speed": math.inf}, "mean_absolute_speed: value is inf rad/s, it must be finite"),
    ):
        answer = ask(listener, **fields)
        assert not answer.success and words in answer.message
        assert not answer.limits
