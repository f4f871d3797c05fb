"""A short recording of the example bag, and its replay."""

import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig


@pytest.fixture(scope="session")
def short_bag(paper_cycle_bag, tmp_path_factory):
    path = tmp_path_factory.mktemp("exchange") / "short"
    return write_recording(path, read_recording(paper_cycle_bag).between(0.0, 30.0))


@pytest.fixture(scope="session")
def replayed(short_bag):
    return replay(read_recording(short_bag), load_rig(), smooth=True)
