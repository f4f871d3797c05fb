"""The test run itself: what tests/conftest.py promises."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pytest

IN_WORKER = pytest.mark.skipif("PYTEST_XDIST_WORKER" not in os.environ, reason="runs without workers")


@IN_WORKER
def test_tests_of_one_file_share_a_worker(request):
    """The scheduler goes by the end of the test's id; some versions of pytest lose it."""
    assert request.node.nodeid.endswith("@tests/workspace/test_test_run.py")


@IN_WORKER
@pytest.mark.live
def test_live_tests_share_a_worker(request):
    assert request.node.nodeid.endswith("@live")


def test_what_takes_long_is_not_left_for_the_end(request, repo_root):
    def item(file, *marks):
        return SimpleNamespace(location=(file, 1, ""), get_closest_marker=lambda mark: mark in marks)

    given = [item("a"), item("b"), item("b", "long"), item("c"), item("a", "live"), item("d", "long", "live"), item("b")]
    made = request.config.pluginmanager.get_plugin(str(repo_root / "tests/conftest.py")).longest_first(given)
    assert [given.index(one) for one in made] == [4, 5, 1, 2, 6, 0, 3]


def test_a_worker_has_a_domain_of_its_own(repo_root, ros_domain):
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    other = "import sys; sys.path.insert(0, 'tests'); import conftest; print(conftest._claim_domain())"
    claimed = subprocess.run([sys.executable, "-c", other], cwd=repo_root, capture_output=True, text=True, check=True)
    assert 1 <= int(claimed.stdout) <= 101
    assert int(claimed.stdout) != ros_domain
