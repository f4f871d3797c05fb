"""What the benchmark compares is the same problem, and the accuracy that it claims is there."""

import json
from itertools import islice

import numpy as np
import pytest
from ddh_twin_py.benchmarks import filters
from ddh_twin_py.benchmarks.continuous import SCALE, STATES
from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.benchmarks.free_run_speed import Cycle, errors, loosest, meets, seen
from ddh_twin_py.benchmarks.recorded_run_speed import time_recorded_run
from ddh_twin_py.benchmarks.solvers import compare_symbolic, scipy_lsoda
from ddh_twin_py.benchmarks.tools import NotThere
from ddh_twin_py.cli import benchmarks, live_bench
from ddh_twin_py.cli.arguments import InputError
from ddh_twin_py.cli.main import main
from ddh_twin_py.cli.simulate import START_NS
from ddh_twin_py.cli.simulated import collect
from ddh_twin_py.physics.free_run import HYDRAULIC_STEP
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.duty_file import duty_file
from support.simulated import simulated


@pytest.fixture(scope="module")
def cycle():
    return Cycle(load_rig(), load_duty(duty_file("paper_cycle")), 20.0)


@pytest.fixture(scope="module")
def fine(cycle):
    return cycle.run(HYDRAULIC_STEP / 20, 10)


def test_kernel_solves_the_continuous_equations(cycle, fine):
    """Regularised friction is the only difference left; over 20 s it was 1.8e-3 of a rise."""
    run = scipy_lsoda(cycle.problem())
    states, _ = run(1e-7)
    pressures, rises = seen(states)
    temperature, peaks = errors(pressures, rises, fine)
    assert temperature < 3e-3
    assert peaks < 0.01


def test_a_wrong_equation_would_show(cycle, fine):
    problem = cycle.problem()
    problem.params = problem.params.copy()
    problem.params["pump_1_friction_viscous"] *= 1.05
    states, _ = scipy_lsoda(problem)(1e-6)
    assert errors(*seen(states), fine)[0] > 5e-3


def test_hydraulic_step_is_good_enough(cycle):
    """By its step alone; what intervals of 50 ms add is measured and printed by the benchmark."""
    assert meets(errors(*cycle.run(HYDRAULIC_STEP), cycle.run(HYDRAULIC_STEP / 20)))


def test_shorter_intervals_converge_with_second_order(cycle, fine):
    whole, half = (errors(*cycle.run(HYDRAULIC_STEP / 10, refinement), fine)[0] for refinement in (1, 2))
    assert half < 0.4 * whole


def test_rest_and_stroke_have_rates_of_their_own(cycle):
    problem = cycle.problem()
    at_rest = problem.rates(0.0, problem.initial)
    assert at_rest.shape == (STATES,)
    moving = problem.initial.copy()
    moving[4] = 1.0
    # pump 1 at 50 rad/s against the sheet's displacement raises the piston side's pressure
    assert problem.rates(0.0, moving)[0] > at_rest[0]
    assert SCALE[4] == 50.0


def test_symbolic_equations_are_the_compiled_ones(cycle):
    try:
        assert compare_symbolic(cycle.problem(), 60, seed=3) < 1e-9
    except NotThere as reason:
        pytest.skip(f"CasADi: {reason}")


def test_no_tolerance_good_enough_is_said(fine):
    def hopeless(tolerance):
        return np.zeros((2001, STATES)), 1.0

    with pytest.raises(NotThere, match="no tolerance"):
        loosest(hopeless, fine)


def test_kalman_step_is_the_textbook_filter():
    case = filters.Case(200)
    x, covariance, _ = filters.sequential(case)
    other, other_covariance, _ = filters.with_blas(case)
    np.testing.assert_allclose(x, other, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(covariance, other_covariance, rtol=0.0, atol=1e-9)
    assert np.array_equal(covariance, covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_kalman_step_leaves_out_what_was_not_read():
    case = filters.Case(50)
    fewer = filters.Case(50)
    case.readings[:, 2] = np.nan
    fewer.reading_matrix, fewer.noise = np.delete(fewer.reading_matrix, 2, 0), np.delete(fewer.noise, 2)
    fewer.readings = np.ascontiguousarray(np.delete(fewer.readings, 2, 1))
    for one, other in zip(filters.sequential(case)[:2], filters.sequential(fewer)[:2], strict=True):
        np.testing.assert_array_equal(one, other)


def test_bench_json_is_a_list_of_rows(tmp_path, monkeypatch):
    def tiny(quick, live, quiet):
        found, reasons = filters.compare_filters(20)
        return found, ["numbalsoda: not installed", *reasons], "a machine"

    monkeypatch.setattr(benchmarks, "measure", tiny)
    out = tmp_path / "bench.json"
    assert main(["bench", "--quick", "--no-live", "--quiet", "--json", str(out)]) == 0
    rows = json.loads(out.read_text())
    assert isinstance(rows, list) and len(rows) >= 2
    for row in rows:
        assert {"name", "value", "unit", "against", "ratio"} <= set(row)
        assert isinstance(row["value"], float) and row["value"] > 0.0
    assert rows[0]["ratio"] == pytest.approx(rows[0]["against"] / rows[0]["value"])


def test_what_was_measured_is_kept_where_the_live_nodes_fail(tmp_path, monkeypatch, capsys):
    def failing(*given):
        yield Figure("live at 3 x, speed", 3.0, "x real time", 3.0, "limit", smaller=False)
        raise InputError("node bag_player ended with signal SIGKILL: it said nothing; see nodes.log")

    monkeypatch.setattr(live_bench, "live_figures", failing)
    monkeypatch.setattr(benchmarks, "COMPARISONS", ())
    for part in ("_replay", "_decode", "time_screening", "time_recorded_run"):
        monkeypatch.setattr(benchmarks, part, lambda *given: [Figure("before", 1.0, "s", 2.0)])
    monkeypatch.setattr(benchmarks, "collect", lambda chunks, *given: collect(islice(chunks, 3), START_NS))
    out = tmp_path / "bench.json"
    assert main(["bench", "--quick", "--quiet", "--json", str(out)]) == 2
    assert [row["name"] for row in json.loads(out.read_text())] == ["before"] * 4 + ["live at 3 x, speed"]
    assert "error: the live nodes failed: node bag_player ended with signal SIGKILL" in capsys.readouterr().err


def test_ratio_is_above_one_where_better():
    assert Figure("speed", 10.0, "x", 5.0, smaller=False).ratio == 2.0
    assert Figure("time", 10.0, "s", 5.0).ratio == 0.5
    assert Figure("alone", 10.0, "s", None).ratio is None


def test_a_recording_is_run_over_all_its_intervals():
    figures = {figure.name: figure.value for figure in time_recorded_run(simulated(1, "paper_cycle", 12.0)[0], load_rig())}
    assert set(figures) == {"free run on recorded commands", "temperature filter, a tick"} and min(figures.values()) > 0.0
