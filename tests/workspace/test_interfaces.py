"""ddh_msgs: the contract's types to the letter, and a unit or a meaning on every field."""

import json
import re
from pathlib import Path

import pytest
import yaml
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

CONTRACT = ("DriveTelemetry", "HydraulicTelemetry", "RigInfo")
# What a comment on a number starts with; "" is a pure number.
UNITS = (
    "rad/s",
    "N*m",
    "N",
    "A rms",
    "A^2",
    "V rms",
    "W",
    "Pa gauge",
    "m3/s",
    "m/s",
    "m",
    "kg",
    "s",
    "degC",
    "K",
    "times real time",
    "in the unit above",
    "1",
)


def message_files(repo_root: Path) -> list[Path]:
    return sorted((repo_root / "ddh_msgs/msg").glob("*.msg"))


def service_files(repo_root: Path) -> list[Path]:
    return sorted((repo_root / "ddh_msgs/srv").glob("*.srv"))


def action_files(repo_root: Path) -> list[Path]:
    return sorted((repo_root / "ddh_msgs/action").glob("*.action"))


def interface_files(repo_root: Path) -> list[Path]:
    return message_files(repo_root) + service_files(repo_root) + action_files(repo_root)


def fields(text: str) -> list[tuple[str, str, str]]:
    """Type, name and comment of each field."""
    found = []
    for line in text.splitlines():
        code, _, comment = line.partition("#")
        if code.strip() and code.strip() != "---":
            kind, name = code.split()
            found.append((kind, name, comment.strip()))
    return found


def hashes_in_bag(bag: Path) -> dict[str, str]:
    info = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    return {
        topic["topic_metadata"]["type"]: topic["topic_metadata"]["type_description_hash"]
        for topic in info["topics_with_message_count"]
    }


@pytest.fixture(scope="module")
def typestore(repo_root):
    store = get_typestore(Stores.ROS2_JAZZY)
    types = {}
    for path in message_files(repo_root):
        types |= get_types_from_msg(path.read_text(), f"ddh_msgs/msg/{path.stem}")
    store.register(types)
    return store


def built_hashes(repo_root: Path, name: str) -> dict[str, str]:
    description = repo_root / f"ros2_ws/install/ddh_msgs/share/ddh_msgs/msg/{name}.json"
    return {entry["type_name"]: entry["hash_string"] for entry in json.loads(description.read_text())["type_hashes"]}


@pytest.mark.parametrize("name", CONTRACT)
def test_type_hash_is_the_one_in_the_recording(name, typestore, paper_cycle_bag):
    kind = f"ddh_msgs/msg/{name}"
    assert typestore.hash_rihs01(kind) == hashes_in_bag(paper_cycle_bag)[kind]


def test_built_package_has_the_same_hashes(typestore, repo_root):
    for path in message_files(repo_root):
        kind = f"ddh_msgs/msg/{path.stem}"
        assert built_hashes(repo_root, path.stem)[kind] == typestore.hash_rihs01(kind), kind


@pytest.mark.parametrize("name", CONTRACT)
def test_fields_and_units_are_those_of_the_contract(name, repo_root, shared_dir):
    icd = (shared_dir / "icd.md").read_text()
    block = re.search(rf"`ddh_msgs/msg/{name}`\s+```\n(.*?)```", icd, re.DOTALL)
    assert block, f"icd.md has no definition of {name}"
    ours = fields((repo_root / f"ddh_msgs/msg/{name}.msg").read_text())
    theirs = fields(block.group(1))
    assert [field[:2] for field in ours] == [field[:2] for field in theirs]
    for (_, field, our_comment), (_, _, their_comment) in zip(ours, theirs, strict=True):
        if their_comment:
            assert our_comment == their_comment, field


def test_cmake_lists_every_interface(repo_root):
    cmake = (repo_root / "ddh_msgs/CMakeLists.txt").read_text()
    listed = set(re.findall(r'"((?:msg|srv|action)/\w+\.(?:msg|srv|action))"', cmake))
    there = {f"{p.parent.name}/{p.name}" for p in interface_files(repo_root)}
    assert listed == there


def test_every_field_says_its_unit_or_meaning(repo_root):
    unit = re.compile(rf"({'|'.join(map(re.escape, UNITS))})(,|;|$| )")
    silent = []
    for path in interface_files(repo_root):
        for kind, name, comment in fields(path.read_text()):
            number = kind.removesuffix("[]") in {"float32", "float64"}
            if not comment or (number and not unit.match(comment)):
                silent.append(f"{path.name}: {kind} {name}  # {comment}")
    assert not silent, "\n".join(silent)
