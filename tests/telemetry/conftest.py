import pytest
import yaml
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.units.unit_scales import UnitScales


@pytest.fixture(scope="session")
def paper(paper_cycle_bag):
    return read_recording(paper_cycle_bag)


@pytest.fixture(scope="session")
def noise(repo_root):
    """Noise of one sample by the rig sheet."""
    sheet = yaml.safe_load((repo_root / "ddh_twin_py/ddh_twin_py/rig/ddh_rig.yaml").read_text())
    return {name: sensor["noise"] for name, sensor in sheet["sensors"].items()}


@pytest.fixture(scope="session")
def scales(paper):
    """Load and copper loss by the rig sheet."""
    return UnitScales.of(load_rig(), paper)
