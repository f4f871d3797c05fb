"""Short recordings, and one listener for all tests of a file."""

import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from nodes.processes import Listener


@pytest.fixture(scope="session")
def short_recording(paper_cycle_bag):
    """The first 20 s of the paper's cycle."""
    return read_recording(paper_cycle_bag).between(0.0, 20.0)


@pytest.fixture(scope="session")
def short_bag(short_recording, tmp_path_factory):
    return write_recording(tmp_path_factory.mktemp("bags") / "short", short_recording)


@pytest.fixture(scope="module")
def listener():
    made = Listener()
    yield made
    made.close()
