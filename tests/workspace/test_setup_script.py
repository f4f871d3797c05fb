"""scripts/setup.sh: what it says when something is missing, and that it has nothing to do when done."""

import os
import shutil
import subprocess

import pytest

TOOLS = (
    "bash cat cut dirname env flock git grep head ls make mkdir mktemp rm "
    "sed sh sha256sum sleep sort tail tr uname g++ c++"
).split()
FAKE_PYTHON = "#!/bin/sh\necho '{answer}'\nexit {status}\n"
COMPLETE = FAKE_PYTHON.format(answer="3.12 complete /somewhere/python3.12", status=0)


@pytest.fixture
def bare(tmp_path, repo_root):
    """A copy of the scripts without an environment, and a PATH that holds only what a test puts there."""
    shutil.copytree(repo_root / "scripts", tmp_path / "project/scripts")
    programs = tmp_path / "bin"
    programs.mkdir()
    for tool in TOOLS:
        if found := shutil.which(tool):
            (programs / tool).symlink_to(found)
    return tmp_path


def put(bare, name, text):
    path = bare / "bin" / name
    path.unlink(missing_ok=True)
    path.write_text(text)
    path.chmod(0o755)


def setup(bare, **variables):
    environment = {"PATH": str(bare / "bin"), "HOME": str(bare)} | variables
    return subprocess.run(
        ["bash", str(bare / "project/scripts/setup.sh"), "--check"],
        env=environment,
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )


def only_line(result):
    assert result.returncode == 1, result
    (line,) = result.stderr.splitlines()
    assert "apt-get install -y " in line, line
    return line


@pytest.mark.parametrize(
    ("tools", "package"), [(("git",), "git"), (("make",), "make"), (("g++", "c++", "clang++"), "g++")]
)
def test_missing_tool_is_named_in_one_line_with_the_command(bare, tools, package):
    put(bare, "python3.12", COMPLETE)
    for tool in tools:
        (bare / "bin" / tool).unlink(missing_ok=True)
    assert only_line(setup(bare)).endswith(f"sudo apt-get install -y {package}")


def test_missing_python(bare):
    assert "Python 3.12 or 3.11" in only_line(setup(bare))


def test_python_that_is_too_old_or_does_not_run_is_passed_over(bare):
    put(bare, "python3.12", FAKE_PYTHON.format(answer="", status=127))
    put(bare, "python3", FAKE_PYTHON.format(answer="3.9 complete /usr/bin/python3.9", status=0))
    assert "Python 3.12 or 3.11" in only_line(setup(bare))
    put(bare, "python3.11", FAKE_PYTHON.format(answer="3.11 venv /usr/bin/python3.11", status=0))
    line = only_line(setup(bare))
    assert "venv for Python 3.11" in line
    assert line.endswith("python3.11-venv")


def test_python_without_headers(bare):
    put(bare, "python3", FAKE_PYTHON.format(answer="3.12 dev /usr/bin/python3", status=0))
    assert only_line(setup(bare)).endswith("python3.12-dev")


def test_python_under_pyenv_is_found(bare):
    folder = bare / ".pyenv/versions/3.12.1/bin"
    folder.mkdir(parents=True)
    (folder / "python3").write_text(FAKE_PYTHON.format(answer=f"3.12 venv {folder}/python3", status=0))
    (folder / "python3").chmod(0o755)
    assert str(folder) in only_line(setup(bare))


def test_python_that_was_asked_for_is_named(bare):
    put(bare, "python3.12", COMPLETE)
    assert "DDH_PYTHON=python2.7" in only_line(setup(bare, DDH_PYTHON="python2.7"))


def test_two_things_missing_are_two_lines(bare):
    (bare / "bin/git").unlink()
    result = setup(bare)
    assert result.returncode == 1
    assert len(result.stderr.splitlines()) == 2


def test_foreign_ros_is_left_alone_and_said_so_in_one_line(bare):
    put(bare, "python3.12", COMPLETE)
    (bare / "bin/git").unlink()
    result = setup(bare, AMENT_PREFIX_PATH="/opt/ros/humble", ROS_DISTRO="humble", PYTHONPATH="/opt/ros/humble/lib")
    (line,) = result.stdout.splitlines()
    assert "humble" in line
    assert "left alone" in line


def test_a_set_up_that_is_complete_has_nothing_to_do(repo_root):
    result = subprocess.run(
        [repo_root / "scripts/setup.sh", "--check"],
        env=os.environ | {"DDH_PYTHON": ""},
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )
    assert result.returncode == 0 and result.stdout == "", result.stderr


NO_INDEX = """#!/bin/sh
case "$*" in
  *version_info*) echo 312 ;;
  *venv*) mkdir -p "$3/bin"; cp "$0" "$3/bin/python" ;;
  *) echo "Collecting furo"; echo "ERROR: No matching distribution found for furo==1" >&2; echo "bye"; exit 1 ;;
esac
"""


@pytest.mark.parametrize(("option", "code"), [((), 1), (("--optional",), 0)])
def test_what_pip_says_last_is_on_the_screen(bare, option, code):
    put(bare, "cp", f'#!/bin/sh\nexec {shutil.which("cp")} "$@"\n')
    python = bare / "project/.venv/bin/python"
    python.parent.mkdir(parents=True)
    python.write_text(NO_INDEX)
    python.chmod(0o755)
    (bare / "project/requirements").mkdir()
    (bare / "project/requirements/lock-tools-py312.txt").write_text("furo==1\n")
    done = subprocess.run(["bash", bare / "project/scripts/tools.sh", *option], env={"PATH": str(bare / "bin")}, capture_output=True,
                          text=True, timeout=20)
    assert done.returncode == code
    assert done.stderr.splitlines()[-1] == "tools: ERROR: No matching distribution found for furo==1"
