"""The identifiability table of the documents names what a fit has as unknowns, each once."""

import re

from ddh_twin_py.estimation.fitting.unknowns import AIR, SKEW, uncertain_paths
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.temperature_sensors import SENSORS

PRESSURES = ("pressure_piston_side", "pressure_rod_side")


def test_every_unknown_of_a_fit_stands_once_in_the_table_or_below_it(repo_root):
    page = (repo_root / "docs/calibration.md").read_text(encoding="utf-8")
    part = page[page.index("### Left of the prior's standard deviation"): page.index("\nWhy: ")]
    table = re.findall(r"^\| `([^`]+)` \| ", part, re.M)
    stay = re.findall(r"`([^`]+)`", part[part.index("\n90 % or more is left"):])
    told = table + stay
    wanted = [*uncertain_paths(load_rig()), *(f"measurement.{name}_offset" for name in (*PRESSURES, *SENSORS)), AIR, SKEW]
    assert len(told) == len(set(told))
    assert set(told) == set(wanted)
