"""The node web_view with the whole graph: every stream reaches the page, and the page steers the player."""

import asyncio
import json
import re
import urllib.request

import aiohttp
import pytest
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.web.streams import STATE_FIELDS, STREAMS
from diagnostic_msgs.msg import DiagnosticArray
from nodes.processes import LATCHED, NodeProcess, wait_for

from ddh_msgs.msg import DriveTelemetry, HydraulicState, LimitPrediction, MotorThermalState, PlayerStatus, RigInfo, TemperatureEstimate

pytestmark = pytest.mark.live
NS = "/seen"
NODES = ("hydraulic_model", "machine_thermal", "temperature_fusion", "gap_monitor")
SELDOM = re.compile(r"measured$|innovation|temperature_gap")  # a reading of a sensor that is not there, a bin that is not full


@pytest.fixture(scope="module")
def page(short_recording, tmp_path_factory):
    """Address of the page of a graph that a recording is played to, for ever."""
    bag = write_recording(tmp_path_factory.mktemp("seen") / "bag", short_recording)
    nodes = [NodeProcess(name, NS, flush_after=0.5) for name in NODES[:3]] + [NodeProcess("gap_monitor", NS)]
    view = NodeProcess("web_view", NS, port=0)
    player = NodeProcess("bag_player", NS, bag=str(bag), exit_at_end=False, wait_for_nodes=list(NODES), rate=2.0, clock_rate=0.0, wait=60.0)
    with view:
        yield re.search(r"http://\S+", view.says("page at"))[0]
        for node in (player, *nodes, view):
            with node:
                node.stop()


def state(page):
    with urllib.request.urlopen(f"{page}state", timeout=10.0) as answer:
        return json.load(answer)


def test_every_column_of_every_stream_comes(page):
    def missing():
        values = state(page)["values"]
        return [name for name, value in values.items() if value is None and not SELDOM.search(name)]

    wait_for(lambda: not missing(), 90.0, "all columns")
    for stream in STREAMS:  # and of what comes seldom, some
        wait_for(lambda s=stream: any(state(page)["values"][column] is not None for column in s.columns), 20.0, stream.name)
    found = state(page)["values"]
    assert 20.0 < found["estimate.tank_oil.temperature"] < 40.0 and found["state.known"] == 1.0


def test_documents_tell_rig_limits_gap_health_and_player(page):
    told = wait_for(lambda: (s := state(page)).get("limits") and s.get("gap") and s, 60.0, "limits and gap")
    assert told["rig"]["rig_id"] == "rig_000" and told["page"]["namespace"] == NS
    assert {row["location"] for row in told["limits"]["limits"]} == {"winding_hot_spot", "oil", "seals"}
    assert wait_for(lambda: state(page)["limits"]["warn_within"], 20.0, "what is told of the fusion") == 1800.0
    assert told["gap"]["state"] == "learning" and len(told["gap"]["signals"]) == 16
    assert told["player"]["duration"] == pytest.approx(20.0, abs=0.1)
    assert {row["node"] for row in told["health"]} == {f"{NS[1:]}/{name}" for name in (*NODES, "web_view")}
    name = f"{NS[1:]}/temperature_fusion: temperature/tank_oil"
    with urllib.request.urlopen(f"{page}health?name={urllib.request.quote(name)}", timeout=10.0) as answer:
        assert {"age [s]", "temperature [degC]"} <= {key for key, _ in json.load(answer)}


def test_fields_are_those_of_the_messages():
    doubles = [name for name, kind in HydraulicState.get_fields_and_field_types().items() if kind == "double" and name != "interval"]
    assert list(STATE_FIELDS) == doubles
    for message, stream in ((MotorThermalState, "motor"), (TemperatureEstimate, "estimate")):
        known = set(message.get_fields_and_field_types())
        named = {column.split(".")[-1] for s in STREAMS if s.name == stream for column in s.columns if "temperature." not in column}
        assert named - {"ambient"} <= known, named - known


def test_the_page_pauses_seeks_and_sets_the_rate(page):
    async def ask(*wishes):
        told = []
        async with aiohttp.ClientSession() as session, session.ws_connect(f"{page}ws") as ws:
            for number, (name, value) in enumerate(wishes):
                await ws.send_str(json.dumps({"do": name, "value": value, "id": number}))
                while True:
                    message = await ws.receive(15.0)
                    if message.type is aiohttp.WSMsgType.TEXT and (said := json.loads(message.data))["doc"] == "answer":
                        told.append(said["data"]["refused"])
                        break
        return told

    told = asyncio.run(ask(("pause", True), ("seek", 5.0), ("rate", 1.0), ("seek", 999.0), ("rate", "fast"), ("dance", 1)))
    assert told[:3] == ["", "", ""]
    assert "offset is 999 s, allowed are 0 to 20.0" in told[3] and "it must be a number" in told[4] and "no 'dance'" in told[5]
    player = wait_for(lambda: (p := state(page)["player"])["paused"] and p, 5.0, "the pause")
    assert player["position"] == pytest.approx(5.0, abs=0.01) and player["rate"] == 1.0
    sensors = wait_for(lambda: [row for row in state(page)["sensors"] if row["state"] == "paused"], 5.0, "sensors that stand still")
    assert len(sensors) == 12
    assert asyncio.run(ask(("pause", False))) == [""]
    wait_for(lambda: state(page)["player"]["position"] > 7.0, 10.0, "playing on")


def test_what_cannot_be_served_is_said_in_one_line(page):
    port = int(page.rstrip("/").rpartition(":")[2])
    with NodeProcess("web_view", NS, port=port) as second:
        assert second.ends() == 2
        words = rf"error: parameters host and port: the page cannot be served at 127.0.0.1:{port}: .*in use"
        assert re.search(words, second.text), second.text
        assert "Traceback" not in second.text


def test_beyond_this_machine_a_token_is_made_up_and_logged():
    with NodeProcess("web_view", "/open", host="0.0.0.0", port=0) as view:
        url = re.search(r"http://\S+", view.says("page at"))[0]
        assert re.search(r"\?token=\S{20,}$", url)
        view.stop()


def test_nodes_without_a_namespace_are_heard_of():
    with NodeProcess("web_view", "/", port=0) as view, NodeProcess("hydraulic_model", "/") as model:
        address = re.search(r"http://\S+", view.says("page at"))[0]

        def heard():
            return {row["node"] for row in state(address).get("health", []) if row["lines"]}

        wait_for(lambda: {"hydraulic_model", "web_view"} <= heard(), 60.0, "health of both")
        model.stop()
        view.stop()


def test_messages_that_are_not_sound_are_left_out(listener):
    cut = b"\0\1\0\0"
    sent = {
        "/cut/bag_player/status": (PlayerStatus, LATCHED, cut), "/cut/rig": (RigInfo, LATCHED, cut),
        "/cut/temperature/limits": (LimitPrediction, 10, cut), "/diagnostics": (DiagnosticArray, 10, cut + bytes(8) + b"\1\0\0\0cut/x"),
        "/cut/hydraulics/state": (HydraulicState, 10, HydraulicState(heat_nodes=["housing"])),
    }  # fmt: skip
    publishers = {topic: listener.node.create_publisher(kind, topic, profile) for topic, (kind, profile, _) in sent.items()}
    with NodeProcess("web_view", "/cut", port=0) as view:
        view.says("ready")
        for topic, (kind, _, message) in sent.items():
            wait_for(publishers[topic].get_subscription_count, 10.0, topic)
            publishers[topic].publish(message)
            view.says(f"{topic}: a message is no sound {kind.__name__}", 10.0)
        view.stop()
    for publisher in publishers.values():
        listener.withdraw(publisher)


def test_a_page_without_telemetry_names_where_there_is_some(listener):
    publishers = [listener.node.create_publisher(DriveTelemetry, f"{place}/drive/telemetry", 10)
                  for place in ("/nowhere", "/elsewhere")]
    with NodeProcess("web_view", "/nowhere", port=0) as view:
        address = re.search(r"http://\S+", view.says("page at"))[0]
        wait_for(lambda: "/elsewhere" in state(address).get("elsewhere", []), 20.0, "the other namespace")  # beside those of other tests
        assert "nothing comes in /nowhere, but a drive speaks in" in view.says("/elsewhere", 10.0)
        wait_for(lambda: listener.node.count_subscribers("/nowhere/drive/telemetry"), 10.0, "its own topic")
        assert "/nowhere" not in state(address)["elsewhere"] and "speaks in /nowhere" not in view.text
        view.stop()
    for publisher in publishers:
        listener.withdraw(publisher)
