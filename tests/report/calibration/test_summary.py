"""The terminal summary of a calibration: readable at 80 columns."""

import io
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.calibration import Calibration, FittedParameter
from ddh_twin_py.estimation.fitting.comparison import Discrepancy
from ddh_twin_py.estimation.fitting.unknowns import uncertain_paths
from ddh_twin_py.report.calibration.groups import SignalFit, signal_fits, verdict
from ddh_twin_py.report.calibration.page import calibration_document
from ddh_twin_py.report.calibration.summary import print_calibration
from ddh_twin_py.report.units import in_file
from ddh_twin_py.rig import load_rig
from rich.console import Console


def test_nothing_is_cut_at_80_columns():
    rig = load_rig()
    zeros = [path for path in rig.quantities if path.startswith("measurement.") and path.endswith("_offset")]
    parameters = []
    for i, path in enumerate([*uncertain_paths(rig), *zeros]):
        quantity = rig.quantities[path]
        prior_std = quantity.standard_deviation or 1.0
        value = quantity.value - 1.2345678 * prior_std
        parameters.append(FittedParameter(path, quantity.unit, quantity.value, prior_std, value, (0.123, 0.789)[i % 2] * prior_std, True))
    rms = {"temperature/cylinder_barrel": 123.456, "pressure_piston_side": 1.0}
    fit = Calibration(rig, parameters, np.eye(len(parameters)), rms, rms, 3, True, Discrepancy())
    console = Console(width=80, record=True, file=io.StringIO())
    print_calibration(fit, signal_fits(fit, {}), "said", console)
    lines = console.export_text().splitlines()
    assert not any("…" in line or len(line) > 80 for line in lines)
    first = {line.split()[0]: line for line in lines if line.strip()}
    for p in parameters:
        assert p.name in first
        assert "e+" not in first[p.name] and f"{100 * p.share:.0f} %" in first[p.name]
        assert f"  {in_file(p.value, p.std)}" in first[p.name]


@pytest.mark.parametrize(("value", "std", "unit", "said"), [
    (408.7, 6053.1, "Pa", "409 ± 6053 Pa"), (0.007092, 0.00021, "1", "0.00709 ± 0.00021"), (284.5, 9.94, "N", "284.5 ± 9.9 N"),
    (2.27973e-5, 5.2e-9, "m3/rev", "(2.2797 ± 0.0005)e-5 m3/rev"), (1.472e9, 3.1e7, "Pa", "(1.472 ± 0.031)e9 Pa"),
    (-0.0555, 0.123, "K", "−0.06 ± 0.12 K"), (0.0, 1.0, "K", "0 ± 1 K"),
])
def test_value_and_deviation_share_digits_and_notation(value, std, unit, said):
    p = FittedParameter("a.b", unit, value, 10.0 * std, value, std, True)
    fit = Calibration(load_rig(), [p], np.eye(1), {}, {}, 3, True, Discrepancy())
    console = Console(width=80, record=True, file=io.StringIO())
    print_calibration(fit, [], "said", console)
    (row,) = (line for line in console.export_text().splitlines() if line.startswith("a.b"))
    assert re.split(" {2,}", row)[1] == said


def test_a_signal_that_the_fit_made_worse_is_said_to_be():
    fit = SimpleNamespace(asked=("pump_1.leakage",), settled=True, parameters=(), refused=())
    signals = [SignalFit("temperature/cylinder_barrel", 1.5, 1.72, None, 0), SignalFit("current", 3.0, 1.69, None, 0)]
    said, _ = verdict(fit, signals, 0.0)
    assert verdict(fit, [SignalFit("speed", 9.0, 4.9, None, 0)], 0.0)[1] == "fair"  # as everywhere else
    assert "temperature/cylinder barrel 1.72 (made worse by the fit, 1.50 as given), current 1.69 (2 of 2 signals)" in said


def test_what_was_asked_for_is_named_with_its_value_and_counted_apart():
    asked, zero, refused = (FittedParameter(name, unit, 1.6, 0.1, 1.599, std, True) for name, unit, std in (
        ("motor.torque_constant", "N*m/A", 0.0018), ("measurement.tank_oil_offset", "K", 0.01), ("tank.emissivity", "1", 0.0999)))
    fit = Calibration(load_rig(), [asked, refused, zero], np.eye(3), {"speed": 1.2}, {"speed": 1.0}, 3, True, Discrepancy(),
                      (refused,), (asked.name, refused.name))
    signals = [SignalFit("speed", 1.2, 1.0, None, 0)]
    said, level = verdict(fit, signals, 0.0)
    assert said.startswith("Fitted: motor.torque_constant 1.599 ± 0.002 N*m/A. The fitted twin's free run is within")
    page = calibration_document(fit, [], signals, 0.0, said, level, "x.yaml", 1.0).html()
    assert "<dt>Parameters asked for</dt><dd>2<small>and 1 that every fit needs: zero errors of sensors and clocks</small>" in page
    assert "ddh-twin replay gives other numbers: it compares means over 50 ms, without the first 5 s" in page
    whole = replace(fit, asked=(), refused=())
    assert verdict(whole, signals, 0.0)[0].startswith("The fitted twin's")
    assert "<dt>Parameters fitted</dt><dd>3<" in calibration_document(whole, [], signals, 0.0, said, level, "x.yaml", 1.0).html()


def test_parameters_at_the_end_of_their_tolerance_are_named():
    ended, inside = (FittedParameter(name, "1", 1.0, 0.1, 1.0 + 0.1 * moved, 0.01, True) for name, moved in (("a.b", -2.5), ("c.d", 1.3)))
    fit = SimpleNamespace(asked=(), settled=True, parameters=(ended, inside), refused=())
    said, level = verdict(fit, [SignalFit("current", 3.0, 1.0, None, 0)], 0.0)
    assert "a.b ended 2.5 standard deviations off, which is as far as a fit may go" in said and "c.d" not in said and level == "fair"
