"""Package metadata that rosdep and colcon read, and paths that belong to nobody's machine."""

import re
import subprocess
from xml.etree import ElementTree

import pytest

# Imported module to rosdep key or ROS package that provides it.
KEYS = {
    "aiohttp": "python3-aiohttp",
    "numpy": "python3-numpy",
    "scipy": "python3-scipy",
    "numba": "python3-numba",
    "yaml": "python3-yaml",
    "rich": "python3-rich",
    "rosbags": "python3-rosbags-pip",
    "apsw": "python3-rosbags-pip",
    "lz4": "python3-rosbags-pip",
    "backports": "python3-rosbags-pip",
}
ROS = (
    "rclpy std_msgs sensor_msgs diagnostic_msgs rosgraph_msgs std_srvs lifecycle_msgs ddh_msgs launch launch_ros "
    "rcl_interfaces geometry_msgs builtin_interfaces ament_index_python"
).split()


def manifest(repo_root, package):
    return ElementTree.parse(repo_root / package / "package.xml").getroot()


def dependencies(root):
    return {element.text for element in root if element.tag.endswith("depend")}


@pytest.mark.parametrize(
    ("package", "build_type"), [("ddh_msgs", "ament_cmake"), ("ddh_twin_py", "ament_python")]
)
def test_manifest(repo_root, package, build_type):
    root = manifest(repo_root, package)
    assert root.get("format") == "3"
    assert root.findtext("name") == package
    assert root.findtext("license") == "Apache-2.0"
    assert root.find("maintainer").get("email")
    assert root.findtext("export/build_type") == build_type


def test_manifest_and_setup_agree_on_the_version(repo_root):
    setup = (repo_root / "ddh_twin_py/setup.py").read_text()
    assert f'version="{manifest(repo_root, "ddh_twin_py").findtext("version")}"' in setup


def test_every_import_is_declared(repo_root):
    declared = dependencies(manifest(repo_root, "ddh_twin_py"))
    needed = set()
    for path in (repo_root / "ddh_twin_py").rglob("*.py"):
        for module in re.findall(r"^\s*(?:import|from) (\w+)", path.read_text(), re.MULTILINE):
            if module in KEYS:
                needed.add(KEYS[module])
            elif module in ROS:
                needed.add(module)
    assert needed <= declared, f"package.xml lacks {needed - declared}"


def test_licence(repo_root):
    assert "Apache License" in (repo_root / "LICENSE").read_text()[:200]


def test_no_file_that_users_run_names_a_place_of_this_workplace(repo_root):
    listing = subprocess.run(
        ["git", "-c", "safe.directory=*", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=repo_root,
        capture_output=True,
        text=True,
        check=True,
    )
    found = []
    for name in filter(None, listing.stdout.split("\0")):
        path = repo_root / name
        if name.startswith(("tests/", ".ci/")) or name.endswith((".md", ".mcap", ".db3")) or not path.is_file():
            continue
        text = path.read_bytes().decode("utf-8", errors="replace")
        found += [f"{name}: {place}" for place in ("../shared", "/work/") if place in text]
    assert not found, "\n".join(found)
