"""What is said of a graph that was listened to, made of arrays; of the installation; of the clock."""

import sys
import time
from dataclasses import replace
from importlib import metadata

import numpy as np
import pytest
from ddh_twin_py.bags.cdr import encode_stamped_floats
from ddh_twin_py.bags.message_types import know
from ddh_twin_py.cli.main import main
from ddh_twin_py.doctor import clock, installation
from ddh_twin_py.doctor.check import Check, as_json, worst
from ddh_twin_py.doctor.machine import check_machine, machines
from ddh_twin_py.doctor.middleware import check_middleware
from ddh_twin_py.doctor.survey import Health, HeardTopic, Survey
from ddh_twin_py.doctor.twin import check_twin
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.signals import RIG_TYPE, TOPIC_TYPES

NOW = 1_780_000_000_000_000_000
SECONDS = 5.0
NOISE = {name: spec.noise for name, spec in load_rig().sensors.items()}


def heard(relative, rate, values, *, namespace="/ddh", delay=0.002, stamp_shift=0.0, **changes):
    """A topic that comes at a rate (1/s) with noise on its values."""
    n = round(SECONDS * rate)
    arrived = NOW + (np.arange(n) / rate * 1e9).astype(np.int64)
    stamps = arrived - round((delay - stamp_shift) * 1e9)
    noise = np.random.default_rng(1).normal(0.0, 0.01, (n, len(values)))
    messages = [bytes(m) for m in encode_stamped_floats(stamps, np.array(values) * (1.0 + noise), "ddh")]
    topic = HeardTopic(f"{namespace}/{relative}", (TOPIC_TYPES[relative],), ("/machine",), True, False, arrived, messages)
    return replace(topic, **changes)


def rig_message(payload=149.5, latched=True):
    store = know(RIG_TYPE)
    header = store.types["std_msgs/msg/Header"](store.types["builtin_interfaces/msg/Time"](1, 0), "")
    message = store.types[RIG_TYPE](header, "press_7", "ISO VG 32", payload)
    content = bytes(store.serialize_cdr(message, RIG_TYPE))
    return HeardTopic("/ddh/rig", (RIG_TYPE,), ("/machine",), False, latched, np.array([NOW]), [content])


def graph(*changed, without=()):
    """A sound machine with the twin beside it; topics given replace those of the same name."""
    several = [
        heard("drive/telemetry", 100.0, (52.0, 52.0, 16.0, 9.0, 60.0, 900.0)),
        heard("hydraulics/telemetry", 100.0, (90e5, 20e5, 0.2, 0.067)),
        heard("temperature/ambient", 2.0, (23.0, 0.0)), heard("temperature/tank_oil", 2.0, (35.0, 0.0)),
        rig_message(), *changed,
    ]
    topics = {topic.topic: topic for topic in several if topic.topic not in without}
    nodes = ("/machine", *(f"/ddh/{name}" for name in ("hydraulic_model", "machine_thermal", "temperature_fusion", "gap_monitor")))
    return Survey(SECONDS, 7, "rmw_fastrtps_cpp", nodes, topics, ("/rosout",), (), False, 0.6)


def of(checks, level):
    return [f"{check.name}: {check.found}" for check in checks if check.level == level]


def test_a_sound_machine_has_nothing_wrong():
    checks = check_machine(graph(), "/ddh", NOISE)
    assert worst(checks) == "ok", of(checks, "warning") + of(checks, "error")
    assert {check.name for check in checks} >= {"/ddh/drive/telemetry", "/ddh/rig", "stamps", "samples"}
    assert "/ddh/drive/telemetry: 100 per second" in of(checks, "ok")
    drive = graph().topics["/ddh/drive/telemetry"]
    piled_up = replace(drive, arrived=drive.arrived[-1] - (drive.arrived[-1] - drive.arrived) // 2)
    told = of(check_machine(graph(piled_up), "/ddh", NOISE), "ok")
    assert "/ddh/drive/telemetry: 100 per second" in told, "taken in at once, sent as before"
    assert machines(graph()) == ["/ddh"] and machines(graph(without=["/ddh/drive/telemetry", "/ddh/hydraulics/telemetry"])) == []


@pytest.mark.parametrize("changed, level, expected", [
    (heard("drive/telemetry", 20.0, (52.0, 52.0, 16.0, 9.0, 60.0, 900.0)), "warning", "/ddh/drive/telemetry: 20 per second"),
    (heard("drive/telemetry", 100.0, (52.0, 52.0, 16.0, 9.0, 60.0, 900.0), types=("std_msgs/msg/Float64",)), "error",
     "/ddh/drive/telemetry: type std_msgs/msg/Float64"),
    (heard("drive/telemetry", 100.0, (52.0, 52.0, 16.0, 9.0, 60.0, 900.0), publishers=("/a", "/b")), "error",
     "/ddh/drive/telemetry: 2 publishers: /a, /b"),
    (heard("hydraulics/telemetry", 100.0, (90e5, 20e5, 0.2, 0.067), arrived=np.empty(0, np.int64), messages=[]), "error",
     "/ddh/hydraulics/telemetry: 0 messages in 5 s"),
    (heard("hydraulics/telemetry", 100.0, (90e5, 20e5, 0.2, 0.067), stamp_shift=-2.0), "warning",
     "/ddh/hydraulics/telemetry: its stamps lie 2 s behind those of drive/telemetry"),
    (heard("hydraulics/telemetry", 100.0, (90e5, 20e5, 0.2, 0.067), messages=[b"\0\1\0\0torn"] * 500), "error",
     "/ddh/hydraulics/telemetry: messages cannot be decoded"),
    (rig_message(payload=0.0), "warning", "/ddh/rig: press_7, ISO VG 32, payload 0 kg"),
    (rig_message(payload=1e9), "warning", "/ddh/rig: press_7, ISO VG 32, payload 1e+09 kg"),
    (rig_message(payload=float("inf")), "warning", "/ddh/rig: press_7, ISO VG 32, payload inf kg"),
    (rig_message(latched=False), "warning", "/ddh/rig: not transient local"),
    (heard("temperature/ambient", 0.2, (23.0, 0.0)), "note", "/ddh/temperature/ambient: 1 messages in 5 s"),
])
def test_what_is_wrong_is_named(changed, level, expected):
    checks = check_machine(graph(changed), "/ddh", NOISE)
    assert expected in of(checks, level), [*of(checks, "warning"), *of(checks, "error")]
    assert all(check.advice for check in checks if check.level != "ok")


def test_a_wrong_unit_is_an_error_or_warning():
    checks = check_machine(graph(heard("drive/telemetry", 100.0, (52.0, 497.0, 16.0, 9.0, 60.0, 900.0))), "/ddh", NOISE)
    assert any("rpm" in said for said in of(checks, "error") + of(checks, "warning"))


def test_what_is_missing_and_what_may_have_meant_it():
    survey = replace(graph(without=["/ddh/hydraulics/telemetry", "/ddh/rig"]), other_topics=("/ddh/hydraulic/telemetry",))
    found = {check.name: check for check in check_machine(survey, "/ddh", NOISE)}
    assert found["/ddh/hydraulics/telemetry"].level == "warning"
    assert found["/ddh/hydraulics/telemetry"].advice.endswith("did /ddh/hydraulic/telemetry mean it?")
    assert found["/ddh/rig"].level == "warning"
    own = replace(graph(without=["/ddh/temperature/ambient"]), other_topics=("/ddh/temperature/limits", "/ddh/temperature/residuals"))
    advice = {check.name: check for check in check_machine(own, "/ddh", NOISE)}["/ddh/temperature/ambient"].advice
    assert "mean it" not in advice, advice
    none = check_machine(graph(without=["/ddh/drive/telemetry"]), "/ddh", NOISE)
    assert "/ddh/drive/telemetry: nobody publishes it" in of(none, "error")


def test_a_message_that_cannot_be_decoded_moves_no_clock():
    """Of a topic of one per second the first one of five is cut."""
    air = heard("temperature/ambient", 1.0, (23.0, 0.0))
    checks = check_machine(graph(replace(air, messages=[b"\0\1\0\0torn", *air.messages[1:]])), "/ddh", NOISE)
    assert of(checks, "error") == ["/ddh/temperature/ambient: messages cannot be decoded"] and of(checks, "warning") == []


def test_a_stamp_that_is_none_is_told_as_that():
    air = heard("temperature/ambient", 1.0, (23.0, 0.0))
    odd = air.messages[0][:8] + (4 * 10**9).to_bytes(4, "little") + air.messages[0][12:]
    checks = check_machine(graph(replace(air, messages=[odd, *air.messages[1:]])), "/ddh", NOISE)
    assert of(checks, "error") == ["/ddh/temperature/ambient: header.stamp nanosec 4000000000"] and of(checks, "warning") == []


def test_clocks_that_differ_and_a_recording_that_is_played():
    late = [heard("drive/telemetry", 100.0, (52.0, 52.0, 16.0, 9.0, 60.0, 900.0), delay=3600.0),
            heard("hydraulics/telemetry", 100.0, (90e5, 20e5, 0.2, 0.067), delay=3600.0),
            heard("temperature/ambient", 2.0, (23.0, 0.0), delay=3600.0), heard("temperature/tank_oil", 2.0, (35.0, 0.0), delay=3600.0)]
    stamps = {check.name: check for check in check_machine(graph(*late), "/ddh", NOISE)}["stamps"]
    assert (stamps.level, stamps.found) == ("warning", "stamps are 3600 s behind this computer's clock")
    played = {check.name: check for check in check_machine(replace(graph(*late), clock_published=True), "/ddh", NOISE)}["stamps"]
    assert played.level == "note"


DRIVE = ("drive/telemetry", 100.0, (52.0, 52.0, 16.0, 9.0, 60.0, 900.0))
HYDRAULICS = ("hydraulics/telemetry", 100.0, (90e5, 20e5, 0.2, 0.067))
OIL = ("temperature/tank_oil", 2.0, (35.0, 0.0))


@pytest.mark.parametrize("shift, said", [(7200.0, "7200 s ahead of"), (-60.0, "60 s behind")])
@pytest.mark.parametrize("alone", [DRIVE, HYDRAULICS, OIL])
def test_of_several_streams_the_one_by_another_clock_is_named_alone(alone, shift, said):
    checks = check_machine(graph(heard(*alone, stamp_shift=shift)), "/ddh", NOISE)
    assert of(checks, "error") == [f"/ddh/{alone[0]}: its stamps lie {said} those of most streams"] and not of(checks, "warning")


@pytest.mark.parametrize("alone", [DRIVE, HYDRAULICS])
def test_of_two_streams_that_are_apart_none_is_called_wrong(alone):
    two = graph(heard(*alone, stamp_shift=60.0), without=["/ddh/temperature/ambient", "/ddh/temperature/tank_oil"])
    checks = check_machine(two, "/ddh", NOISE)
    said = [text for text in of(checks, "error") + of(checks, "warning") if "ambient" not in text]
    assert len(said) == 1 and said[0].startswith(f"/ddh/{alone[0]}: its stamps lie 60 s ahead of"), said


@pytest.mark.parametrize("loop", [5.0, None])
def test_on_a_busy_computer_clocks_are_not_blamed_first(loop):
    """Streams that are seconds apart, and all of them seconds late; hours are of a clock."""
    busy = "this computer is busy or discovery was late, which looks the same"

    def advice(name, *changed, loop=loop):
        checks = check_machine(replace(graph(*changed), loop=loop), "/ddh", NOISE)
        return next(check.advice for check in checks if check.name == name and "stamps" in (check.name, *check.found.split()))

    apart = heard(*HYDRAULICS, stamp_shift=-2.0)
    assert busy in advice("/ddh/hydraulics/telemetry", apart) and busy not in advice("/ddh/hydraulics/telemetry", apart, loop=0.6)
    air = ("temperature/ambient", 2.0, (23.0, 0.0))
    late, old = ([heard(*one, delay=delay) for one in (DRIVE, HYDRAULICS, OIL, air)] for delay in (2.0, 3600.0))
    assert busy in advice("stamps", *late) and busy not in advice("stamps", *late, loop=0.6) and busy not in advice("stamps", *old)


def test_the_twins_own_nodes():
    survey = graph()
    silent = check_twin(survey, "/ddh")
    assert "/ddh/temperature/estimates: 0 messages in 5 s" in of(silent, "warning")
    n = 100
    stamps = NOW + np.arange(n) * 50_000_000
    content = [bytes(m) for m in encode_stamped_floats(stamps, np.zeros((n, 1)))]
    state = HeardTopic("/ddh/hydraulics/state", ("x",), ("/ddh/hydraulic_model",), False, False, NOW + np.arange(n) * 20_000_000, content)
    piled_up = replace(survey, topics={**survey.topics, state.topic: state})
    assert "/ddh/hydraulics/state: 20 per second" in of(check_twin(piled_up, "/ddh"), "ok"), "taken in at once, sent as before"
    bad = replace(survey, health=(Health("ddh/temperature_fusion: estimate", 2, "no estimate"), Health("other: x", 2, "not ours")))
    assert of(check_twin(bad, "/ddh"), "error") == ["ddh/temperature_fusion: estimate: no estimate"]
    twice = replace(survey, nodes=(*survey.nodes, "/ddh/gap_monitor"))
    assert "/ddh/gap_monitor: runs 2 times" in of(check_twin(twice, "/ddh"), "error")
    (none,) = check_twin(replace(survey, nodes=("/machine",)), "/ddh")
    assert none.level == "note" and "ddh-twin up --namespace /ddh" in none.advice


@pytest.mark.parametrize("changes, level, name", [
    ({"loop": None, "topics": {}}, "error", "between processes"), ({"loop": 4.0}, "warning", "between processes"),
    ({"middleware": "rmw_cyclonedds_cpp"}, "note", "implementation"),
    ({"environment": {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}}, "note", "reach"),
    ({"environment": {"FASTRTPS_DEFAULT_PROFILES_FILE": "/nowhere/x.xml"}}, "error", "profile"),
])
def test_middleware(changes, level, name):
    assert any(check.level == level and check.name == name and check.advice for check in check_middleware(replace(graph(), **changes)))


@pytest.mark.parametrize(("environment", "advice"), [
    ({}, "discovery is slow: set FASTRTPS_DEFAULT_PROFILES_FILE to ddh_twin_py/config/fastdds_profile.xml"),
    ({"FASTRTPS_DEFAULT_PROFILES_FILE": __file__}, "discovery is slow though FASTRTPS_DEFAULT_PROFILES_FILE is set: see whether the "
                                                   "computer is busy"),
])  # fmt: skip
def test_slow_discovery_is_told_with_what_can_be_done(environment, advice):
    checks = {check.name: check for check in check_middleware(replace(graph(), loop=4.0, environment=environment))}
    assert (checks["between processes"].level, checks["between processes"].advice) == ("warning", advice)


def test_a_busy_computer_is_no_firewall():
    late, cut_off = (next(check for check in check_middleware(survey) if check.name == "between processes")
                     for survey in (replace(graph(), loop=None), replace(graph(), loop=None, topics={})))
    assert late.level == "warning" and "computer is busy" in late.advice and "5 topics came" in late.found
    assert cut_off.level == "error" and "firewall" in cut_off.advice


def test_inputs_that_are_stale_are_one_line():
    names = ["drive/telemetry", *(f"temperature/{name}" for name in ("ambient", "tank_oil", "line_a"))]
    health = [Health(f"ddh/{node}: {name}", 1 + (name == names[0]), f"stale: {k}.0 s without a message, limit 1 s")
              for k, name in enumerate(names) for node in ("hydraulic_model", "temperature_fusion")]
    (line,) = [check for check in check_twin(replace(graph(), health=tuple(health)), "/ddh") if "stale" in check.name + check.found]
    assert line.level == "error" and line.found == f"{', '.join(names)}: of ddh/hydraulic_model, ddh/temperature_fusion"
    alone = check_twin(replace(graph(), health=tuple(health[:1])), "/ddh")
    assert [check.name for check in alone if "stale" in check.found] == ["ddh/hydraulic_model: drive/telemetry"]


def test_installation(monkeypatch, tmp_path):
    assert worst(installation.check_installation(tmp_path)) in ("ok", "warning")
    monkeypatch.setattr(installation, "NEEDED", ("numpy", "no-such-package-here"))
    monkeypatch.setenv("ROS_DISTRO", "humble")
    monkeypatch.setattr(sys, "version_info", (3, 9, 1))
    said = {check.name: check for check in installation.check_installation(tmp_path)}
    assert said["packages"].found == "missing: no-such-package-here" and said["packages"].advice == "run make setup"
    assert said["Python"].level == "error" and said["ROS 2"].level == "warning"


def test_packages_of_single_verbs_are_a_note_and_that_of_the_live_page_an_error(monkeypatch, tmp_path):
    absent = {"pyarrow", "shtab"}
    version = metadata.version

    def installed(name):
        if name in absent:
            raise metadata.PackageNotFoundError(name)
        return version(name)

    monkeypatch.setattr(metadata, "version", installed)
    said = {check.name: check for check in installation.check_installation(tmp_path)}["packages"]
    assert (said.level, said.found) == ("note", "missing: pyarrow, shtab")
    assert said.advice == "needed by export --parquet, fleet --parquet (pyarrow); completion (shtab) alone: run make setup"
    absent.add("aiohttp")
    said = {check.name: check for check in installation.check_installation(tmp_path)}["packages"]
    assert (said.level, said.found) == ("error", "missing: aiohttp")


def test_clock(monkeypatch):
    assert [check.name for check in clock.check_clock()] == ["date", "synchronisation"]
    assert clock._synchronised(5).level == "note" and clock._synchronised(0).level == "ok" and clock._synchronised(None).level == "note"
    monkeypatch.setattr(time, "time", lambda: 0.0)
    (only,) = clock.check_clock()
    assert (only.level, only.found) == ("error", "1970-01-01 00:00:00 UTC")


def test_levels_and_json():
    checks = [Check("a", "b", "ok", "x"), Check("a", "c", "warning", "y", "z", "do")]
    assert worst(checks) == "warning" and worst([]) == "ok"
    data = as_json(checks)
    assert data["counts"] == {"ok": 1, "note": 0, "warning": 1, "error": 0} and data["checks"][1]["advice"] == "do"
    with pytest.raises(ValueError, match="'fatal' is no level"):
        Check("a", "b", "fatal", "x")


def test_the_verb_without_a_graph(capsys, tmp_path, monkeypatch):
    assert main(["doctor", "--no-graph"]) == 0
    assert "installation" in capsys.readouterr().out
    monkeypatch.setattr(installation, "NEEDED", ("no-such-package-here",))
    assert main(["doctor", "--no-graph", "--quiet"]) == 1
    out = capsys.readouterr().out
    assert "✗ packages: missing: no-such-package-here" in out and "→ run make setup" in out and "✓" not in out
