"""The test run itself: what tests/conftest.py promises."""

import os
import subprocess
import sys

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


def test_a_worker_has_a_domain_of_its_own(repo_root, ros_domain):
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    other = "import sys; sys.path.insert(0, 'tests'); import conftest; print(conftest._claim_domain())"
    claimed = subprocess.run([sys.executable, "-c", other], cwd=repo_root, capture_output=True, text=True, check=True)
    assert 1 <= int(claimed.stdout) <= 101
    assert int(claimed.stdout) != ros_domain
