"""What every test may use: paths, the example recording, a ROS 2 domain of its own.

Tests that start nodes carry ``@pytest.mark.live`` and run on one worker; tests that measure
time carry ``@pytest.mark.alone`` and run while the other worker waits. Files that take long carry
``@pytest.mark.long`` and begin early, so that no worker waits at the end for one of them.
"""

import fcntl
import os
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LOCKS = Path(tempfile.gettempdir()) / f"ddh-twin-tests-{os.getuid()}"
# Above 101 the ports of a domain lie in the range that Linux hands out to clients.
DOMAINS = range(1, 102)

_domain_lock = None


def _claim_domain() -> int:
    """A ROS_DOMAIN_ID that no other worker or test run on this machine uses, held until exit."""
    global _domain_lock
    LOCKS.mkdir(exist_ok=True)
    first = os.getpid() % len(DOMAINS)
    for domain in (*DOMAINS[first:], *DOMAINS[:first]):
        lock = open(LOCKS / f"domain-{domain}", "w")  # stays open for as long as it is held
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
            continue
        _domain_lock = lock
        return domain
    raise pytest.UsageError(f"all ROS 2 domains {DOMAINS.start} to {DOMAINS.stop - 1} are in use by other test runs")


def pytest_configure(config: pytest.Config) -> None:
    os.environ["ROS_DOMAIN_ID"] = str(_claim_domain())
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.pop("ROS_LOCALHOST_ONLY", None)
    # The workers of one run share this name; it is where they wait for each other.
    run = os.environ.setdefault("DDH_TEST_RUN", str(os.getpid()))
    config.stash[_run_key] = run


_run_key = pytest.StashKey[str]()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Tests of one file share its fixtures, hence a worker; live tests share the processor, hence too."""
    for item in items:
        if item.get_closest_marker("xdist_group") is None:
            group = "live" if item.get_closest_marker("live") else item.location[0]
            item.add_marker(pytest.mark.xdist_group(group))
        if item.get_closest_marker("live"):  # best-effort messages may be lost on a loaded machine: once more, and said
            item.add_marker(pytest.mark.flaky(reruns=1))
    if "PYTEST_XDIST_WORKER" in os.environ:  # tests are handed out in this order (--no-loadscope-reorder)
        items[:] = longest_first(items)


def longest_first(items: list[pytest.Item]) -> list[pytest.Item]:
    """The live tests, the files in which a test is marked long, the others; within each as they were collected."""

    def rank(item: pytest.Item) -> int:
        return 0 if item.get_closest_marker("live") else 1 if item.location[0] in long else 2

    long = {item.location[0] for item in items if item.get_closest_marker("long")}
    return sorted(items, key=rank)


@contextmanager
def _among_tests(run: str, alone: bool):
    """Any number of ordinary tests at a time, or one that is alone.

    Whoever enters passes the gate; one that wants to be alone keeps it shut while it waits
    for the others to leave, so that no new one slips in before it.
    """
    with open(LOCKS / f"gate-{run}", "w") as gate, open(LOCKS / f"room-{run}", "w") as room:
        fcntl.flock(gate, fcntl.LOCK_EX)
        fcntl.flock(room, fcntl.LOCK_EX if alone else fcntl.LOCK_SH)
        fcntl.flock(gate, fcntl.LOCK_UN)
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item):
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return (yield)
    with _among_tests(item.config.stash[_run_key], item.get_closest_marker("alone") is not None):
        return (yield)


def pytest_unconfigure(config: pytest.Config) -> None:
    if "PYTEST_XDIST_WORKER" not in os.environ:
        for name in ("gate", "room"):
            (LOCKS / f"{name}-{config.stash[_run_key]}").unlink(missing_ok=True)


@pytest.fixture(scope="session")
def repo_root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def paper_cycle_bag(repo_root: Path) -> Path:
    """The paper's lift-lower cycle, recorded on the nominal rig."""
    return repo_root / "bags" / "paper_cycle"


@pytest.fixture(scope="session")
def shared_dir(repo_root: Path) -> Path:
    """Data that lies beside the checkout and is no part of it."""
    given = os.environ.get("DDH_SHARED")
    path = Path(given) if given else repo_root.parent / "shared"
    if not path.is_dir():
        pytest.skip(f"no shared data at {path} (DDH_SHARED names another place)")
    return path


@pytest.fixture(scope="session")
def ros_domain() -> int:
    """The domain of this worker; set in the environment, so processes that a test starts are in it."""
    return int(os.environ["ROS_DOMAIN_ID"])
