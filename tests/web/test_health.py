"""Nodes and sensors: what is well, what is not, what says nothing any more."""

import math

import pytest
from ddh_twin_py.web.health import ERROR, OK, SILENT, SILENT_AFTER, WARN, Health, Sensors

TANK = "temperature/tank_oil"


@pytest.fixture
def health():
    made = Health(["ddh/hydraulic_model"])
    made.take("ddh/temperature_fusion: clock", OK, "runs forward", [("jumps [1]", "0")], 100.0)
    made.take(f"ddh/temperature_fusion: {TANK}", WARN, "stuck (3 times)", [("stuck [1]", "3")], 100.0)
    return made


def node(health, name, wall):
    return next(row for row in health.document(wall) if row["node"] == f"ddh/{name}")


def test_a_node_is_as_bad_as_the_worst_that_it_says(health):
    row = node(health, "temperature_fusion", 100.5)
    assert row["level"] == WARN and row["message"] == TANK
    assert row["lines"] == [[TANK, WARN, "stuck (3 times)"], ["clock", OK, "runs forward"]]
    health.take("ddh/temperature_fusion: clock", 3, "stale", [], 101.0)  # STALE of diagnostic_msgs is no node that is silent
    assert node(health, "temperature_fusion", 101.0)["level"] == ERROR


def test_a_node_that_has_not_reported_or_does_not_any_more(health):
    never = node(health, "hydraulic_model", 100.0)
    assert never == {"node": "ddh/hydraulic_model", "level": SILENT, "lines": [], "message": "not heard of"}
    row = node(health, "temperature_fusion", 100.0 + SILENT_AFTER + 1.0)
    assert row["level"] == SILENT and "says nothing any more" in row["message"] and len(row["lines"]) == 2


def test_the_values_behind_a_line(health):
    assert health.values(f"ddh/temperature_fusion: {TANK}") == [("stuck [1]", "3")]
    assert health.values("ddh/nobody: clock") == [] == health.values("")


def test_of_a_topic_the_worst_counts_that_somebody_says_who_still_speaks(health):
    health.take(f"ddh/hydraulic_model: {TANK}", ERROR, "unit suspect", [], 100.0 - SILENT_AFTER - 1.0)
    assert health.of_topic(TANK, 100.0) == (WARN, "stuck (3 times)")
    assert health.of_topic("temperature/line_a", 100.0) == (OK, "")


def sensor(sensors, health, wall, paused=False, topic="drive/telemetry"):
    return next(row for row in sensors.document(health, wall, paused) if row["topic"] == topic)


def test_a_sensor_comes_in_stops_and_comes_back():
    sensors, health = Sensors(["drive/telemetry", TANK]), Health()
    assert sensor(sensors, health, 0.0)["state"] == "absent"
    for k in range(40):
        sensors.arrived("drive/telemetry", 5, {"speed": 1.0}, 0.05 * k, 10.0 + 0.05 * k)
    assert sensor(sensors, health, 12.0)["state"] == "ok"
    assert sensor(sensors, health, 12.0, paused=True)["state"] == "paused"
    row = sensor(sensors, health, 15.0)
    assert row["state"] == "stopped" and row["why"] == "no message for 3 s" and row["age"] == pytest.approx(3.05, abs=0.1)
    sensors.arrived("drive/telemetry", 5, {"speed": 1.0}, 5.0, 15.0)
    assert sensor(sensors, health, 15.1)["state"] == "ok"
    assert sensor(sensors, health, 15.1, topic=TANK)["state"] == "absent"


@pytest.mark.parametrize("speed", [0.5, 1.0, 5.0])
def test_a_rate_is_that_of_the_data_however_fast_it_is_played(speed):
    sensors, health = Sensors(["drive/telemetry"]), Health()
    for k in range(100):
        sensors.arrived("drive/telemetry", 5, {"speed": 1.0}, 0.05 * k * speed, 10.0 + 0.05 * k)
        row = sensor(sensors, health, 10.0 + 0.05 * k)
    assert row["rate"] == pytest.approx(100.0 / speed)


def test_a_slow_sensor_has_not_stopped_between_two_readings():
    sensors, health = Sensors([TANK]), Health()
    for k in range(6):
        sensors.arrived(TANK, 1, {"reading": 20.0}, 10.0 * k, 10.0 * k)
    assert sensor(sensors, health, 65.0, topic=TANK)["state"] == "ok"
    assert sensor(sensors, health, 80.0, topic=TANK)["state"] == "stopped"


def test_a_reading_that_is_none_and_what_the_nodes_say(health):
    sensors = Sensors([TANK])
    sensors.arrived(TANK, 1, {"reading": math.nan}, 0.0, 100.0)
    assert sensor(sensors, health, 100.1, topic=TANK) | {"age": None} == {
        "topic": TANK, "name": "tank_oil", "rate": None, "age": None, "state": "error", "why": "reading not a number",
    }  # fmt: skip
    sensors.arrived(TANK, 1, {"reading": 21.0}, 0.2, 100.2)
    row = sensor(sensors, health, 100.3, topic=TANK)
    assert (row["state"], row["why"]) == ("warn", "stuck (3 times)")
