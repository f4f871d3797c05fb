"""The compose file's services, each with network, memory and address of its own, without docker.

Network namespaces on a bridge and a private /dev/shm are what docker gives a service. So this runs
the commands of the compose file through the image's entry point, and asks whether the services find
each other and whether what the twin says arrives at the recorder.
"""

import functools
import os
import shlex
import shutil
import subprocess

import pytest
from rosbags.highlevel import AnyReader

SERVICES = ("hydraulic_model", "machine_thermal", "temperature_fusion", "gap_monitor", "bag_recorder", "bag_player")
UNSHARE = ("unshare", "--net", "--mount", "--ipc", "--pid", "--fork", "--kill-child")


@functools.cache
def namespaces_work() -> bool:
    """Root, util-linux, iproute2 and a kernel that lets this process make bridges and pairs."""
    if not (shutil.which("unshare") and shutil.which("ip")):
        return False
    attempt = "ip link add dds type bridge && ip link add veth1 type veth peer name eth0 && mount -t tmpfs none /dev/shm"
    return subprocess.run([*UNSHARE, "sh", "-c", attempt], capture_output=True, check=False).returncode == 0


def script(repo_root, compose, places, more) -> str:
    """Shell that sets up the bridge, starts the services, waits for the player and stops the rest."""
    lines = [
        "set -e",
        "mount --make-rprivate /",
        "mount -t tmpfs none /run",
        "mkdir /run/netns",
        "ip link set lo up",
        "ip link add dds type bridge",
        "ip addr add 172.30.0.1/24 dev dds",
        "ip link set dds up",
    ]
    for number, name in enumerate(SERVICES, 2):
        arguments = [*compose["services"][name]["command"], *more.get(name, [])]
        for inside, outside in places.items():
            arguments = [a.replace(f":={inside}/", f":={outside}/") for a in arguments]
        command = shlex.join([str(repo_root / "docker/entrypoint.sh"), *arguments])
        start = shlex.quote(f"mount -t tmpfs none /dev/shm; exec {command}")
        lines += [
            f"ip netns add {name}",
            f"ip link add veth{number} type veth peer name eth0 netns {name}",
            f"ip link set veth{number} master dds up",
            f"ip -n {name} addr add 172.30.0.{number}/24 dev eth0",
            f"ip -n {name} link set lo up",
            f"ip -n {name} link set eth0 up",
            f"ip -n {name} route add default via 172.30.0.1",
            f"ip netns exec {name} unshare --mount --ipc sh -c {start} > {places['/logs']}/{name} 2>&1 &",
            f"{name}=$!",
        ]
    others = " ".join(f"${name}" for name in SERVICES if name != "bag_player")
    lines += ["wait $bag_player", "sleep 1", f"kill -TERM {others}", f"wait {others}"]
    return "\n".join(lines)


@pytest.mark.live
@pytest.mark.skipif(not namespaces_work(), reason="needs root and network namespaces with bridges")
def test_services_find_each_other_and_the_twin_is_recorded(repo_root, compose, paper_cycle_bag, tmp_path):
    places = {"/bags": paper_cycle_bag.parent}
    for inside in ("/state", "/recordings", "/logs"):
        places[inside] = tmp_path / inside.strip("/")
        places[inside].mkdir()
    quick = {"bag_player": ["-p", "rate:=0.0", "-p", "start_offset:=310.0"]}
    text = script(repo_root, compose, places, quick)
    environment = {"PATH": os.environ["PATH"], "HOME": os.environ["HOME"], "ROS_DOMAIN_ID": "0"}
    result = subprocess.run(
        [*UNSHARE, "bash", "-c", text], env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    said = "\n".join(f"{log.name}: {log.read_text()}" for log in sorted(places["/logs"].iterdir()))
    assert result.returncode == 0, result.stderr + said

    with AnyReader([places["/recordings"] / "twin"]) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
    sent = 2 * 19.9 * 100  # both streams, 100 Hz, what is left of the recording
    received = counts["/ddh/drive/telemetry"] + counts["/ddh/hydraulics/telemetry"]
    assert abs(received - sent) < 50, counts
    assert counts["/ddh/temperature/estimates"] > 300, counts
    assert list(places["/state"].iterdir()), said
