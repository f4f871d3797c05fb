"""What a user has after set-up: activation, the executables, ROS 2 with Fast DDS and its profile."""

import os
import re
import runpy
import shutil
import socket
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest

SHELLS = [shell for shell in ("bash", "dash", "zsh") if shutil.which(shell)]


def clean_environment(**more: str) -> dict[str, str]:
    kept = {name: os.environ[name] for name in ("HOME", "ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")}
    return kept | {"PATH": "/usr/local/bin:/usr/bin:/bin"} | more


def run(command, env, **more):
    result = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, check=False, **more)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def entry_points(repo_root, tmp_path_factory):
    """Console scripts as setup.py declares them: name to module."""
    calls = {}
    import setuptools

    original, setuptools.setup = setuptools.setup, lambda **given: calls.update(given)
    folder = os.getcwd()
    try:
        os.chdir(repo_root / "ddh_twin_py")
        runpy.run_path("setup.py")
    finally:
        os.chdir(folder)
        setuptools.setup = original
    pairs = (line.split(" = ") for line in calls["entry_points"]["console_scripts"])
    return {name: target.removesuffix(":main") for name, target in pairs}


def test_every_executable_is_where_ros2_run_looks_and_runs_in_the_environment(repo_root, entry_points):
    folder = repo_root / "ros2_ws/install/ddh_twin_py/lib/ddh_twin_py"
    assert len(entry_points) == 10
    for name in entry_points:
        first = (folder / name).read_text().splitlines()[0]
        assert first == f"#!{repo_root}/.venv/bin/python", name


def test_before_set_up_has_ended_the_command_says_so(repo_root, tmp_path):
    root, executable = tmp_path / "it's here", tmp_path / "built"
    (tmp_path / "ddh").mkdir()
    (tmp_path / "ddh" / "env.sh").touch()
    command = tmp_path / "ddh-twin"
    command.write_text(runpy.run_path(str(repo_root / "scripts/make_environment.py"))["launcher"](root, tmp_path, executable))
    command.chmod(0o755)
    early = subprocess.run([command, "info"], env=clean_environment(), capture_output=True, text=True, timeout=60, check=False)
    assert (early.returncode, early.stdout) == (2, "")
    assert early.stderr == f"ddh-twin: the set-up in {root} is not complete; run there: make setup\n"
    executable.write_text('#!/bin/sh\nprintf "%s " "$@"\n')
    executable.chmod(0o755)
    assert run([command, "info", "a b"], clean_environment()) == "info a b "


def test_every_executable_has_its_module(entry_points):
    missing = [module for module in entry_points.values() if find_spec(module) is None]
    assert not missing


@pytest.mark.parametrize("shell", SHELLS)
def test_activation_is_enough_and_deactivation_puts_everything_back(shell, repo_root, tmp_path):
    script = f"""
        env | sort > {tmp_path}/before
        . {repo_root}/.venv/bin/activate
        . {repo_root}/.venv/bin/activate
        command -v ddh-twin > {tmp_path}/command
        python -c 'import ddh_msgs.action, ddh_msgs.msg, ddh_msgs.srv, ddh_twin_py, rclpy; ddh_msgs.msg.RigInfo()' || exit 1
        deactivate
        env | sort > {tmp_path}/after
    """
    run([shell, "-c", script], clean_environment(PS1="> ", AMENT_PREFIX_PATH="/opt/ros/humble", PYTHONPATH="/x"))
    assert (tmp_path / "command").read_text().strip() == f"{repo_root}/.venv/bin/ddh-twin"
    before, after = (
        [line for line in (tmp_path / name).read_text().splitlines() if not line.startswith(("_=", "PS1="))]
        for name in ("before", "after")
    )
    assert after == before


def test_sourcing_the_workspace_is_enough(repo_root):
    check = "import ddh_msgs.msg, ddh_twin_py, rclpy; rclpy.init(); rclpy.create_node('n'); print('ok')"
    script = f'source {repo_root}/ros2_ws/install/setup.bash && {repo_root}/.venv/bin/python -c "{check}"'
    assert run(["bash", "-c", script], clean_environment()).strip() == "ok"


def test_command_works_without_activation_and_shuts_a_foreign_ros_out(repo_root, tmp_path):
    """Packages of the same names on PYTHONPATH, as another ROS 2 has them, are not taken."""
    for name in ("rclpy", "ddh_msgs", "ddh_twin_py", "numpy"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('foreign')\n")
    foreign = clean_environment(
        PYTHONPATH=str(tmp_path),
        AMENT_PREFIX_PATH="/opt/ros/humble",
        LD_LIBRARY_PATH="/opt/ros/humble/lib",
        RMW_IMPLEMENTATION="rmw_cyclonedds_cpp",
        ROS_DISTRO="humble",
    )
    assert "usage: ddh-twin" in run([repo_root / ".venv/bin/ddh-twin", "--help"], foreign)
    inside = run(["sh", "-c", f". {repo_root}/.venv/ddh/env.sh; env"], foreign)
    assert "humble" not in inside
    assert "cyclonedds" not in inside


def test_a_profile_of_the_users_own_wins(repo_root):
    env = clean_environment(FASTRTPS_DEFAULT_PROFILES_FILE="/my/profile.xml")
    inside = run(["sh", "-c", f". {repo_root}/.venv/ddh/env.sh; env"], env)
    assert "FASTRTPS_DEFAULT_PROFILES_FILE=/my/profile.xml" in inside


def test_messages_cross_processes(repo_root, ros_domain):
    """One process publishes RigInfo, another receives it: middleware, type support and discovery work."""
    publish = (
        "import rclpy, sys, ddh_msgs.msg as m\n"
        "from rclpy.qos import QoSProfile, DurabilityPolicy as D\n"
        "rclpy.init(); n = rclpy.create_node('p')\n"
        "p = n.create_publisher(m.RigInfo, 'rig', QoSProfile(depth=1, durability=D.TRANSIENT_LOCAL))\n"
        "p.publish(m.RigInfo(rig_id='r1', payload_mass=200.0)); print('up', flush=True); sys.stdin.read()\n"
    )
    listen = (
        "import rclpy, ddh_msgs.msg as m\n"
        "from rclpy.qos import QoSProfile, DurabilityPolicy as D\n"
        "rclpy.init(); n = rclpy.create_node('s'); got = []\n"
        "n.create_subscription(m.RigInfo, 'rig', got.append, QoSProfile(depth=1, durability=D.TRANSIENT_LOCAL))\n"
        "end = n.get_clock().now().nanoseconds + 20e9\n"
        "while not got and n.get_clock().now().nanoseconds < end: rclpy.spin_once(n, timeout_sec=0.1)\n"
        "print(got[0].rig_id, got[0].payload_mass)\n"
    )
    environment = ["sh", "-c", f'. {repo_root}/.venv/ddh/env.sh; exec "$@"', "sh", sys.executable, "-c"]
    with subprocess.Popen(
        [*environment, publish], env=clean_environment(), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as publisher:
        try:
            assert publisher.stdout.readline() == "up\n"
            assert run([*environment, listen], clean_environment()).strip() == "r1 200.0"
        finally:
            publisher.stdin.close()
            publisher.wait(10)


def announcements(repo_root: Path, domain: int, profile: Path, seconds: float) -> int:
    """Discovery packets that one participant sends, in its first seconds, to a port that is not its own."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        # Port of the third participant of a domain on this machine, where a newcomer announces itself too.
        listener.bind(("127.0.0.1", 7400 + 250 * domain + 10 + 2 * 3))
        listener.settimeout(0.05)
        start = f"import rclpy, time; rclpy.init(); n = rclpy.create_node('n'); time.sleep({seconds})"
        command = f'. {repo_root}/.venv/ddh/env.sh; exec {sys.executable} -c "{start}"'
        with subprocess.Popen(
            ["sh", "-c", command], env=clean_environment(FASTRTPS_DEFAULT_PROFILES_FILE=str(profile))
        ) as process:
            count, end = 0, None
            while end is None or time.monotonic() < end:
                try:
                    data = listener.recv(65536)
                except TimeoutError:
                    if process.poll() is not None:
                        break
                    continue
                if data.startswith(b"RTPS"):
                    count += 1
                    end = end or time.monotonic() + seconds
            process.terminate()
    return count


@pytest.mark.alone
def test_fast_dds_reads_the_profile(repo_root, ros_domain, tmp_path):
    """With it a participant announces itself 20 times in its first second and 4 times in each after that.

    Without it it does so 6 times in 2 s.
    """
    ours = repo_root / "ddh_twin_py/config/fastdds_profile.xml"
    assert f"={ours}\n" in run(["sh", "-c", f". {repo_root}/.venv/ddh/env.sh; env"], clean_environment())
    neutral = tmp_path / "neutral.xml"
    neutral.write_text(re.sub(r"<discovery_config>.*</discovery_config>", "", ours.read_text(), flags=re.DOTALL))
    ElementTree.parse(neutral)
    with_it = announcements(repo_root, ros_domain, ours, 2.0)
    without = announcements(repo_root, ros_domain, neutral, 2.0)
    assert with_it >= 15, with_it
    assert with_it >= without + 8, (with_it, without)


def test_package_data_is_installed(repo_root, tmp_path):
    """A copy, as plain colcon build makes it, holds every file that is no module."""
    source = tmp_path / "source"
    ignore = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")
    shutil.copytree(repo_root / "ddh_twin_py", source, ignore=ignore)
    build = [sys.executable, "setup.py", "-q", "build", "--build-base", str(tmp_path / "build")]
    run(build, dict(os.environ), cwd=source)
    wanted = {str(p.relative_to(source)) for p in (source / "ddh_twin_py").rglob("*") if p.is_file()}
    built = {str(p.relative_to(tmp_path / "build/lib")) for p in (tmp_path / "build/lib").rglob("*") if p.is_file()}
    assert "ddh_twin_py/rig/ddh_rig.yaml" in built
    assert wanted == built
