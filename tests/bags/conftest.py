import shutil

import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording


@pytest.fixture(scope="session")
def paper(paper_cycle_bag):
    return read_recording(paper_cycle_bag)


@pytest.fixture(scope="session")
def short(paper):
    """Twelve seconds of the paper's cycle: a lift, with all sensors."""
    return paper.between(0.0, 12.0)


@pytest.fixture(scope="session")
def written(tmp_path_factory, short):
    return write_recording(tmp_path_factory.mktemp("written") / "field", short)


@pytest.fixture
def bag(tmp_path, written):
    """A copy that a test may change."""
    return shutil.copytree(written, tmp_path / "field")
