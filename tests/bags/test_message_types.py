"""The definitions kept here are those of the ddh_msgs package and of the interface."""

import re

import pytest
from ddh_twin_py.bags.definitions import definition_problem
from ddh_twin_py.bags.message_types import TELEMETRY_DEFINITIONS, know, output_definitions, typestore

HASHES = {  # as recorded in bags/paper_cycle/metadata.yaml, by rosidl's own rule
    "ddh_msgs/msg/DriveTelemetry": "RIHS01_fe605f9b4eeb42908c884ad98753dacd2dc9ca0d64b467173578350a4bf117b3",
    "ddh_msgs/msg/HydraulicTelemetry": "RIHS01_03d113f4271b2bdd1b43f41865458b661f0568564d8c78ec0d2b5fe6f81da347",
    "ddh_msgs/msg/RigInfo": "RIHS01_d6726f641c347e8e194af55a798a48a1dbc7eab5ccb4bb5dd28c313509e277bd",
    "sensor_msgs/msg/Temperature": "RIHS01_72514a14126ab9f8a9abec974c78e5610a367b59db5da355ff1fb982d5bad4b8",
}


def test_texts_are_those_of_the_package(repo_root):
    for name, text in TELEMETRY_DEFINITIONS.items():
        assert (repo_root / "ddh_msgs" / "msg" / f"{name.split('/')[-1]}.msg").read_text("utf8") == text


@pytest.mark.parametrize("name", HASHES)
def test_hashes_are_those_of_the_recorded_bags(name):
    assert typestore().hash_rihs01(name) == HASHES[name]


def test_all_messages_of_the_package_are_known(repo_root):
    names = {f"ddh_msgs/msg/{path.stem}" for path in (repo_root / "ddh_msgs" / "msg").glob("*.msg")}
    assert names == set(TELEMETRY_DEFINITIONS) | set(output_definitions())
    for name in names:
        assert re.fullmatch("RIHS01_[0-9a-f]{64}", know(name).hash_rihs01(name))


def test_without_a_workspace_the_telemetry_is_still_known(monkeypatch, tmp_path):
    import ddh_twin_py.bags.message_types as message_types

    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    monkeypatch.setattr(message_types, "__file__", str(tmp_path / "a" / "b" / "c" / "d" / "message_types.py"))
    assert output_definitions() == {}
    assert set(HASHES) <= set(message_types.telemetry_typestore().fielddefs)
    with pytest.raises(KeyError, match="no definition of 'ddh_msgs/msg/Absent'; source the workspace"):
        know("ddh_msgs/msg/Absent")


def test_a_definition_that_lacks_a_type_it_needs_is_told_and_not_followed():
    damaged = f"std_msgs/Header header\nfloat64 temperature\n{'=' * 80}\nMSG: std_msgs/Headez\nstring frame_id\n"
    said = definition_problem("sensor_msgs/msg/Temperature", damaged, "ros2msg", "")
    assert said == "has a definition of 'sensor_msgs/msg/Temperature' that cannot be parsed: 'std_msgs/msg/Header'"
