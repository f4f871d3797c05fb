"""The page of the physics against the code: names exist, no quantity of the sheet is missing, constants agree."""

import importlib
import re
from fnmatch import fnmatchcase

import pytest
from ddh_twin_py.physics import cylinder, free_run, motor, oil, pump, soft_sensor, thermal_network
from ddh_twin_py.physics.balance import OPERATING_FIELDS
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.ambient import AMBIENT_LAG

RIG = load_rig()


@pytest.fixture(scope="module")
def page(repo_root):
    return (repo_root / "docs/physics.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def names(page):
    """Names in the page's backticks; one that begins with a point has the section of the name before it."""
    found, section = [], ""
    for name in re.findall(r"`([^`\n]+)`", page):
        if name.startswith("."):
            name = section + name
        section = name.rpartition(".")[0]
        found.append(name)
    return found


def code_has(name: str) -> bool:
    module, _, attribute = name.rpartition(".")
    if module in ("balance", "cylinder", "hydraulics", "motor", "oil", "pump", "thermal_network"):
        return hasattr(importlib.import_module(f"ddh_twin_py.physics.{module}"), attribute)
    return any(fnmatchcase(field, name) for field in OPERATING_FIELDS)


def test_every_name_of_the_symbol_table_is_one_of_the_sheet_or_of_the_code(page):
    section = ""
    for line in page[page.index("## Symbols"):].splitlines()[4:]:
        for name in re.findall(r"`([^`]+)`", line.split(" | ")[-1]):
            name = section + name if name.startswith(".") else name
            section = name.rpartition(".")[0]
            known = any(fnmatchcase(path, name) for path in RIG.quantities) or code_has(name) or name == "speed_command"
            assert known, f"{name}: {line}"


def test_every_quantity_of_the_sheet_stands_on_the_page(names):
    missing = [path for path in RIG.quantities if not any(fnmatchcase(path, name) for name in names)]
    assert not missing


@pytest.mark.parametrize(("text", "value", "scale"), [
    (r"p_v = (\S+) bar", oil.VAPOUR_PRESSURE, 1e5),
    (r"p₀ = (\S+) Pa", oil.ATMOSPHERE, 1.0),
    (r"n = (\S+), p_abs", oil.POLYTROPIC_EXPONENT, 1.0),
    (r"stated for (\S+)…100 °C", oil.STATED_FROM - oil.ZERO_CELSIUS, 1.0),
    (r"stated for −20…(\S+) °C", oil.STATED_TO - oil.ZERO_CELSIUS, 1.0),
    (r"tanh\(ω / (\S+) rad/s\)", pump.SIGN_WIDTH, 1.0),
    (r"end stops F_e: (\S+)·10⁷ N/m", cylinder.END_STOP_STIFFNESS, 1e7),
    (r"side reads below (\S+) bar", soft_sensor.SUCTION_BELOW, 1e5),
    (r"min\(max\(\((\S+) °C − T_w\)", motor.CUT_OFF_AT - oil.ZERO_CELSIUS, 1.0),
    (r"cut back from (\S+) °C on", motor.CUT_BACK_FROM - oil.ZERO_CELSIUS, 1.0),
    (r"(\S+)·10⁻⁵ K/W\)|1/\(R_m \+ 10⁻⁵ K/W\)", thermal_network.MIXED, 1e-5),
    (r"(\S+) nodes: slot winding", thermal_network.N, 1.0),
    (r"constant, (\S+)·10⁻⁸ \|", thermal_network.STEFAN_BOLTZMANN, 1e-8),
    (r"smoothed over (\S+) s", AMBIENT_LAG, 1.0),
    (r"\| (\S+) ms; 2\.5 ms", free_run.HYDRAULIC_STEP, 1e-3),
    (r"1 ms; (\S+) ms once", free_run.DAMPED_FACTOR * free_run.HYDRAULIC_STEP, 1e-3),
    (r"not bent by (\S+) rad", free_run.BEND, 1.0),
    (r"rad/s² for (\S+) s", free_run.DAMPED_AFTER, 1.0),
    (r"(\S+) ms once it has been constant", free_run.CALM_STEP, 1e-3),
    (r"been constant for (\S+) s", free_run.CALM_AFTER, 1.0),
    (r"(\S+) ms after 1 s", free_run.STILL_STEP, 1e-3),
    (r"50 ms after (\S+) s", free_run.STILL_AFTER, 1.0),
    (r"at 23 °C: (\S+) Pa·s|oefficients were found: (\S+) Pa·s", RIG["oil.reference_viscosity"], 1.0),
])
def test_constants_of_the_page_are_those_of_the_code(page, text, value, scale):
    found = re.search(text, page)
    assert found, text
    written = next((group for group in found.groups() if group), "1")
    assert float(written.replace(",", "").replace("−", "-")) * scale == pytest.approx(value, rel=1e-3)
