"""scripts/browser.sh with stand-ins for the machine's commands: it installs where it may, and never fails."""

import os
import subprocess

import pytest


@pytest.fixture
def run(repo_root, tmp_path):
    """The script on a machine that has these commands besides the ordinary ones; what it said and what was asked for."""

    def go(**commands):
        folder = tmp_path / "bin"
        folder.mkdir()
        for ordinary in ("bash", "env", "grep", "mktemp", "rm", "tail", "sed"):
            place = next(f"{p}/{ordinary}" for p in ("/usr/bin", "/bin") if os.path.exists(f"{p}/{ordinary}"))
            (folder / ordinary).symlink_to(place)
        asked = tmp_path / "asked"
        asked.touch()
        for name, answer in commands.items():
            file = folder / name.replace("_", "-")
            file.write_text(f'#!/bin/sh\necho "{file.name} $*" >>{asked}\n{answer}\n')
            file.chmod(0o755)
        done = subprocess.run([repo_root / "scripts/browser.sh"], env={"PATH": str(folder)}, capture_output=True, text=True, timeout=30)
        assert done.returncode == 0, done.stderr
        return done.stdout, asked.read_text()

    return go


def test_a_browser_that_is_there_is_enough(run):
    said, asked = run(chromium="exit 0", apt_get="exit 1", id="echo 0")
    assert said == "" and asked == ""


def test_root_installs(run, repo_root):
    if "ID=ubuntu" in open("/etc/os-release").read():
        pytest.skip("on Ubuntu it installs nothing")
    said, asked = run(apt_get="exit 0", id="echo 0")
    assert "installing Chromium" in said and "skipped" not in said
    assert "apt-get update" in asked and "apt-get install -y --no-install-recommends chromium" in asked


@pytest.mark.parametrize(
    ("commands", "words"),
    [
        ({"id": "echo 1000"}, "no apt-get here"),
        ({"apt_get": "exit 0", "id": "echo 1000", "sudo": "exit 1"}, "needs root"),
        ({"apt_get": "echo no network >&2; exit 100", "id": "echo 0"}, "skipped"),
    ],
    ids=["no apt-get", "no root", "no network"],
)  # fmt: skip
def test_without_a_browser_it_says_that_tests_are_skipped_and_goes_on(run, commands, words):
    said, asked = run(**commands)
    assert words in said and "the tests of the live page are skipped" in said
    if commands.get("sudo"):
        assert "apt-get" not in asked.replace("sudo -n", "")
