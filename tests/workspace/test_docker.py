"""The container files, as far as they can be checked without a docker daemon."""

import re
import shlex
import subprocess

import pytest


@pytest.fixture(scope="module")
def instructions(repo_root):
    """Instruction and arguments of each line of the Dockerfile."""
    text = (repo_root / "docker/Dockerfile").read_text().replace("\\\n", " ")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [tuple(line.split(maxsplit=1)) for line in lines]


@pytest.fixture(scope="module")
def nodes(repo_root):
    setup = (repo_root / "ddh_twin_py/setup.py").read_text()
    return set(re.findall(r'"(\w+)"', re.search(r"NODES = \((.*?)\)", setup, re.DOTALL).group(1)))


def test_each_node_is_a_service_and_runs_its_executable(compose, nodes, repo_root):
    assert set(compose["services"]) == nodes
    for name, service in compose["services"].items():
        assert service["command"][0] == name
        assert (repo_root / "ros2_ws/install/ddh_twin_py/lib/ddh_twin_py" / name).is_file()


def test_all_services_share_one_image_and_one_network(compose):
    (network,) = compose["networks"]
    for service in compose["services"].values():
        assert service["networks"] == [network]
        assert service["image"] == "ddh-twin"


def test_names_in_the_compose_file_exist(compose, repo_root):
    volumes = set(compose["volumes"])
    for name, service in compose["services"].items():
        build = service["build"]
        context = (repo_root / "docker" / build["context"]).resolve()
        assert context == repo_root
        assert (context / build["dockerfile"]).is_file()
        for volume in service.get("volumes", ()):
            source = volume.split(":")[0]
            if "/" not in source:
                assert source in volumes, name
            elif volume.endswith(":ro"):
                assert (repo_root / "docker" / source).exists(), name


def test_paths_in_commands_are_mounted_or_in_the_image(compose, repo_root):
    for name, service in compose["services"].items():
        mounted = [volume.split(":")[1] for volume in service.get("volumes", ())]
        for argument in service["command"]:
            for path in re.findall(r":=(/[\w./-]+)", argument):
                if path.startswith("/opt/ddh/"):
                    assert (repo_root / path.removeprefix("/opt/ddh/")).exists(), f"{name}: {path}"
                elif not argument.startswith("__ns:="):
                    assert any(path.startswith(place) for place in mounted), f"{name}: {path}"


def test_variables_are_explained_with_their_defaults(compose_variables, repo_root):
    table = re.findall(r"^\| `(\w+)` \| `([^`]*)` \|", (repo_root / "docker/README.md").read_text(), re.MULTILINE)
    assert dict(table) == compose_variables


def test_parameters_of_the_services_are_parameters_of_the_nodes(compose, repo_root):
    nodes = repo_root / "ddh_twin_py/ddh_twin_py"
    declared = set()
    for folder, word in (("nodes", "Parameter"), ("sources", "Option")):
        for path in (nodes / folder).glob("*.py"):
            declared |= set(re.findall(rf'{word}\(\s*"(\w+)"', path.read_text()))
    for name, service in compose["services"].items():
        command = service["command"]
        given = [command[i + 1].split(":=")[0] for i, word in enumerate(command) if word == "-p"]
        for parameter in given:
            assert parameter.split(".")[-1] in declared, f"{name}: {parameter}"


def test_image_is_made_by_the_script_that_the_tests_use(instructions, repo_root):
    runs = " ".join(arguments for word, arguments in instructions if word == "RUN")
    assert "scripts/setup.sh" in runs
    assert "pip install" not in runs
    assert "colcon" not in runs
    assert (repo_root / "requirements/lock-py312.txt").is_file()


def test_image_holds_all_that_the_set_up_reads(instructions, repo_root):
    copied = [arguments.split()[0] for word, arguments in instructions if word == "COPY"]
    for source in copied:
        assert (repo_root / source).exists(), source
    let_in = (repo_root / "docker/Dockerfile.dockerignore").read_text().splitlines()
    assert {f"!{source}" for source in copied} <= set(let_in)
    script = (repo_root / "scripts/setup.sh").read_text()
    for path in set(re.findall(r"\b((?:scripts|requirements|ddh_msgs|ddh_twin_py)/[\w.-]*)", script)):
        assert any(path.startswith(source) for source in copied), path


def test_image_has_the_prerequisites(instructions, repo_root):
    apt = next(arguments for word, arguments in instructions if word == "RUN" and "apt-get install" in arguments)
    packages = set(shlex.split(apt.split("--no-install-recommends")[1].split("&&")[0]))
    assert {"git", "make", "g++", "python3.12", "python3.12-venv", "python3.12-dev"} <= packages


def test_entrypoint_starts_nodes_and_commands_in_the_environment(repo_root):
    entrypoint = repo_root / "docker/entrypoint.sh"
    foreign = {"PATH": "/usr/bin:/bin", "PYTHONPATH": "/opt/ros/humble", "ROS_DISTRO": "humble"}

    def run(*command):
        return subprocess.run(
            [entrypoint, *command], env=foreign, capture_output=True, text=True, timeout=60, check=False
        )

    ready = run("python", "-c", "import rclpy, ddh_msgs.msg, os; print(os.environ['ROS_DISTRO'])")
    assert ready.stdout.strip() == "jazzy", ready.stderr
    usage = run("ddh-twin", "--help")
    assert usage.returncode == 0, usage.stderr
    assert run("false").returncode == 1


def test_the_state_of_the_fusion_is_called_what_it_is(compose):
    (path,) = (word.partition(":=")[2] for word in compose["services"]["temperature_fusion"]["command"] if word.startswith("state_file:="))
    assert path.endswith(".npz")
