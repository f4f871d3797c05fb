"""The direct driven unit as the diagnosis sees it, and what is held out of its recordings."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.fitting.problem import Problem
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.diagnose import Recordings, diagnose
from ddh_twin_py.gap.drive.case import DriveCase
from ddh_twin_py.gap.drive.direct_drive import DirectDrive
from ddh_twin_py.gap.drive.held_data import HeldData
from ddh_twin_py.gap.evidence.slopes import slopes_of
from ddh_twin_py.gap.shrink.held_runs import traces
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.writer import write_rig
from support.simulated import simulated

LEAK, OFFSET = EFFECTS["pump_1.leakage"], EFFECTS["sensor.pressure_rod_side_offset"]
CUT = 5.0  # of a deviation, beyond which nothing may go


@pytest.fixture(scope="module")
def recording():
    return simulated(1, "mixed", 120.0)[0]


@pytest.fixture(scope="module")
def model(recording):
    """A commissioning recording and two field recordings of unlike length."""
    sheet = load_rig()
    new = Experiment(recording.between(0.0, 30.0), sheet)
    field = [Experiment(recording, sheet, used=0.75), Experiment(recording.between(0.0, 60.0), sheet, used=0.75)]
    return DirectDrive([new], field, sheet)


def test_within_keeps_tolerances_and_laws(model):
    wild = model.within(np.full(model.size, 100.0))
    assert (wild <= CUT).all() and (model.within(-wild * 100.0) >= -CUT).all()
    inside = np.linspace(-0.1, 0.1, model.size)
    np.testing.assert_array_equal(model.within(inside), inside)
    for number in range(3):
        record = model.record(number, model.within(np.full(model.size, -100.0)))
        assert all(record[f"{part}_leakage"][0] >= 0.0 for part in ("pump_1", "pump_2") if f"{part}_leakage" in record.dtype.names)


def test_a_rig_without_any_tolerance_is_said_to_be_one(recording):
    sheet = load_rig()
    exact = replace(sheet, quantities={path: replace(q, tolerance=0.0, std=None) for path, q in sheet.quantities.items()})
    said = "leaves 0 quantities a tolerance"
    for rig, tells in ((sheet, False), (exact, True)):
        assert any(said in note for note in DriveCase([], [Experiment(recording, rig)], rig).notes()) is tells


def test_what_a_rig_is_held_against_is_named(recording, tmp_path):
    file = tmp_path / "crane.yaml"
    file.write_text("rig_id: crane_1\n")
    for rig, words, not_said in ((load_rig(), "no rig file: the rig is held against the reference sheet", "its rig file, and"),
                                 (load_rig(file), "held against its rig file", "reference sheet")):
        said = " ".join(DriveCase([], [Experiment(recording, rig)], rig).notes())
        assert words in said and not_said not in said
        assert ("differs from it by design (stroke, pumps ...) needs its own rig file" in said) is not rig.given


def test_the_end_of_a_recording_is_followed_where_the_oils_warmth_is_read(recording):
    sheet = load_rig()
    few, cold = (replace(recording, temperatures={n: s for n, s in recording.temperatures.items() if n not in gone})
                 for gone in (("tank_oil", "ambient"), ("tank_oil",)))  # the sheet's ambient is another: a warm unit
    whole, partly, cold = Experiment(recording, sheet), Experiment(few, sheet), Experiment(cold, sheet)
    assert {"pressure_rod_side", "temperature/tank_oil"} <= set(DriveCase([], [whole], sheet).followed)
    assert not {"rod_position", "temperature/motor_winding"} & set(DriveCase([], [whole], sheet).followed)
    assert DriveCase([], [partly], sheet).followed == () and DriveCase([], [cold], sheet).followed
    validated = DriveCase([], [whole], sheet, [partly])  # what it leaves open of its begin is taken at its best
    assert "pressure_rod_side" in validated.followed and validated.held_data().open_begins() == [1]


def test_a_field_without_temperatures_says_so_at_once(recording):
    sheet = load_rig()
    ambient = {name: stream for name, stream in recording.temperatures.items() if name == "ambient"}
    cold = DriveCase([], [Experiment(replace(recording, temperatures=ambient), sheet)], sheet)
    assert any("thermal effects cannot be known" in note for note in cold.missing()) and len(set(cold.notes())) == len(cold.notes())
    assert not DriveCase([], [Experiment(recording, sheet)], sheet).missing()


def test_oil_that_no_sensor_reads_may_begin_warmer(recording):
    sheet = load_rig()
    few = replace(recording, temperatures={n: s for n, s in recording.temperatures.items() if n in ("motor_housing", "tank_wall")})
    held = DriveCase([], [Experiment(recording, sheet)], sheet, [Experiment(few, sheet)]).held_data()
    theta, (ways,) = np.zeros(held.model.size), held.open_begins()
    likely, warmer = (held.run(theta, (), [np.eye(1, ways)[0] * one])[0] for one in (0.0, 1.0))
    early = held.signals()[0]["temperature/tank_wall"].time < 3.0
    tank = np.abs(warmer["temperature/tank_wall"] - likely["temperature/tank_wall"])
    assert tank[early].max() < 0.2 and tank.max() > 0.3  # it begins as it is read, and oil warms it
    assert warmer["pressure_piston_side"][-1] != likely["pressure_piston_side"][-1]


def test_each_recording_begins_by_its_own_unknowns_behind_those_of_the_rig(recording):
    sheet = load_rig()
    few = replace(recording, temperatures={n: s for n, s in recording.temperatures.items() if n in ("motor_housing", "motor_winding")})
    model = DriveCase([Experiment(few, sheet)], [Experiment(few, sheet)], sheet)
    likely, warmer = np.zeros(model.size), np.zeros(model.size)
    warmer[-1] = 1.0
    moved = [not np.array_equal(a["current"], b["current"]) for a, b in zip(model.run(likely), model.run(warmer), strict=True)]
    assert moved == [False, True]
    assert model.size == len(model.paths) + 2 and model.of_first(warmer[:-1]).tolist() == likely.tolist()
    spread = np.ones(model.size)
    assert model.rig_with(warmer, (), spread).quantities == model.rig_with(likely, (), spread).quantities
    assert len(model.fitted_parameters(warmer, spread)) == len(model.paths)


@pytest.mark.parametrize("warmer", [0.5, -0.3])
def test_held_out_data_say_themselves_how_warm_oil_began_that_no_sensor_reads(warmer, recording):
    sheet = load_rig()
    few = replace(recording, temperatures={n: s for n, s in recording.temperatures.items() if n in ("motor_housing", "motor_winding")})
    held = Experiment(few, sheet)
    told = held.predict(held.parameters(sheet), begin=[warmer])
    held.signals = {name: replace(signal, measured=told[name]) for name, signal in held.signals.items()}
    model = DriveCase([], [Experiment(recording, sheet)], sheet, [held])
    likely, itself = (model.held_data().run(np.zeros(model.size), (), begin)[0] for begin in ([[0.0]], None))
    off = [np.abs(run["pressure_rod_side"] - told["pressure_rod_side"]).max() for run in (likely, itself)]
    assert off[1] < 0.1 * off[0]


def test_oil_that_no_sensor_reads_is_found_to_have_begun_warmer(recording):
    sheet = load_rig()
    few = replace(recording, temperatures={n: s for n, s in recording.temperatures.items() if n in ("motor_housing", "motor_winding")})
    experiment = Experiment(few, sheet)
    told = experiment.predict(experiment.parameters(sheet), begin=[0.5])
    experiment.signals = {name: replace(signal, measured=told[name]) for name, signal in experiment.signals.items()}
    with ThreadPoolExecutor(2) as pool:
        fit = Problem([experiment], sheet, ["pump_1.leakage", "oil.walther_b"], Discrepancy()).fit(pool)
    np.testing.assert_allclose(fit.theta, [0.0, 0.0, 0.5], atol=0.1)


def test_temperatures_that_are_not_read_are_named(recording):
    sheet = load_rig()
    few = replace(recording, temperatures={n: s for n, s in recording.temperatures.items() if n != "tank_oil"})
    told = [any("tank_oil" in note for note in DriveCase([], [Experiment(r, sheet)], sheet).notes()) for r in (recording, few)]
    assert told == [False, True]


def test_effects_act_in_the_field_and_not_in_commissioning(model):
    theta, acting = np.full(model.size, 0.3), [(LEAK, 0, 1.0), (OFFSET, 0, 2e5)]
    assert model.altered == [False, True, True]
    assert model.record(0, theta, acting) == model.record(0, theta)
    for number in (1, 2):
        assert model.record(number, theta, acting)["measurement_pressure_rod_side_offset"][0] == pytest.approx(
            2e5 + model.record(number, theta)["measurement_pressure_rod_side_offset"][0])
    without, with_it = model.run(theta), model.run(theta, [(OFFSET, 0, 2e5)])
    np.testing.assert_array_equal(without[0]["pressure_rod_side"], with_it[0]["pressure_rod_side"])
    change = (with_it[1]["pressure_rod_side"] - without[1]["pressure_rod_side"])[model.signals[1]["pressure_rod_side"].binning.bin >= 0]
    assert np.median(change) == pytest.approx(2e5, rel=0.02)


def test_sensitivities_are_those_of_the_run(model):
    theta = np.zeros(model.size)
    base = model.run_one(2, theta, (), roughly=True)
    comparisons = [Comparison(s, p, Discrepancy()) for s, p in zip(model.signals, model.run(theta), strict=True)]
    with ThreadPoolExecutor(1) as pool:
        (rows,) = slopes_of(model, pool, theta, comparisons, [2])
    i = model.paths.index("measurement.pressure_piston_side_offset")
    moved = theta.copy()
    moved[i] = 1.0
    change = comparisons[2].features(model.run_one(2, moved, (), roughly=True)) - comparisons[2].features(base)
    pressure = next(b.rows for b in comparisons[2].blocks if b.signal == "pressure_piston_side")
    np.testing.assert_allclose(rows[pressure, i], change[pressure], rtol=0.02)
    assert np.isfinite(rows).all()


@pytest.mark.parametrize("path, share", [("line_a.volume", 0.04), ("cylinder.stribeck_ratio", 0.09), ("oil.air_fraction", 0.01)])
def test_rough_sensitivities_to_what_is_fast_are_those_of_the_runs_that_are_fitted(path, share, model):
    """A fit that steps by others stops where it is not at its lowest; at twice the hydraulic step these are three times as far apart."""
    moved = np.zeros(model.size)
    moved[model.paths.index(path)] = -model.difference
    comparison = Comparison(model.signals[1], model.run_one(1, np.zeros(model.size)), Discrepancy())
    change = {rough: comparison.features(model.run_one(1, moved, roughly=rough))
              - comparison.features(model.run_one(1, np.zeros(model.size), roughly=rough)) for rough in (False, True)}
    assert np.linalg.norm(change[True] - change[False]) < share * np.linalg.norm(change[False])


@pytest.mark.parametrize("name", EFFECTS)
def test_a_rig_file_with_the_effect_gives_the_same_record(name, model, tmp_path):
    """What -o writes is the twin that the diagnosis found, whichever program reads it."""
    effect = EFFECTS[name].along_with(0.7)
    theta, spread = model.within(np.linspace(-0.5, 0.5, model.size)), np.full(model.size, 0.2)
    for law in range(len(effect.laws)):
        acting = [(effect, law, effect.limit(effect.directions[0] * abs(effect.step)))]
        rig = model.rig_written(theta, acting, spread, "fitted to a test")
        read = load_rig(write_rig(tmp_path / f"{law}.yaml", rig))
        expected, found = model.record(1, theta, acting), model.experiments[1].parameters(read)
        apart = {f: (expected[f][0], found[f][0]) for f in expected.dtype.names
                 if not np.allclose(expected[f], found[f], rtol=1e-9, atol=0.0, equal_nan=True)}
        assert not apart, (name, law, apart)
        assert any(expected[f][0] != model.record(1, theta)[f][0] for f in expected.dtype.names)


def test_a_payload_that_was_found_holds_for_recordings_that_declare_another(model, recording, tmp_path):
    acting, spread = [(EFFECTS["load.mass"], 0, 57.5)], np.full(model.size, 0.2)
    read = load_rig(write_rig(tmp_path / "rig.yaml", model.rig_written(np.zeros(model.size), acting, spread, "fitted to a test")))
    declared = model.experiments[1].payload
    assert read["load.payload_mass"] == model.rig["load.payload_mass"]  # the rig declares what it did
    assert read["load.payload_ratio"] == pytest.approx((declared + 57.5) / declared)
    anew = Experiment(recording, read)  # as another run of the diagnosis makes it
    assert anew.parameters(read)["load_payload_mass"][0] == pytest.approx(anew.payload * read["load.payload_ratio"])


def test_a_fitted_payload_is_told_as_the_ratio_to_what_is_declared(recording):
    """Whatever the sheet's own kilograms are; a rig file may have a ratio already."""
    sheet = load_rig()
    heavy = replace(recording, rig=replace(recording.rig, payload_mass=180.0))
    for ratio in (1.0, 1.2):
        model = DriveCase([], [Experiment(heavy, sheet.with_values({"load.payload_ratio": ratio}))],
                          sheet.with_values({"load.payload_ratio": ratio}))
        theta, spread = np.zeros(model.size), np.full(model.size, 0.2)
        theta[model.paths.index("load.payload_mass")] = -2.5
        told = {p.name: p for p in model.fitted_parameters(theta, spread)}
        assert "load.payload_mass" not in told and told["load.payload_ratio"].unit == "1"
        payload = told["load.payload_ratio"]
        assert (payload.prior, payload.value, payload.moved) == pytest.approx((ratio, 0.975 * ratio, -2.5))
        assert payload.std == pytest.approx(0.2 * payload.prior_std) and payload.share == pytest.approx(0.2)
        assert payload.value * 180.0 == pytest.approx(model.record(0, theta)["load_payload_mass"][0])
        assert payload.value == pytest.approx(model.rig_with(theta, [], spread)["load.payload_ratio"])


@pytest.mark.parametrize(("described", "tells"), [("crane_1", True), ("ddh_reference", False), (None, False)])
def test_a_rig_file_of_another_rig_is_told(recording, described, tells):
    """None is the file of the rig that is recorded; the reference sheet is of any."""
    rig = replace(load_rig(), rig_id=described or recording.rig.rig_id)
    notes = DriveCase([], [Experiment(recording, rig)], rig).notes()
    assert any("describes crane_1 and the recording is of" in note for note in notes) is tells


def test_a_rig_file_of_another_rig_stands_first_in_the_sentence_of_a_gap(recording):
    found = diagnose(Recordings([recording.between(0.0, 4.0)]), replace(load_rig(), rig_id="crane_1"))
    told = f"the rig file describes crane_1 and the recording is of {recording.rig.rig_id}; what was fitted to another rig is no tolerance"
    assert found.sentence.startswith(f"Careful: {told} of this one. The recordings allow no answer: ")
    assert sum(told in note for note in found.report["notes"]) == 1 and told in found.report["notes"][0]


def test_fitted_parameters_carry_their_spread_and_source(model):
    rig = model.rig_written(np.full(model.size, 0.1), [], np.full(model.size, 0.2), "fitted to a test")
    path = next(p for p in model.paths if not p.startswith("measurement."))
    scale = model.problem.scale[model.paths.index(path)]
    quantity = rig.quantities[path]
    assert quantity.value == pytest.approx(model.rig[path] + 0.1 * scale) and quantity.std == pytest.approx(0.2 * scale)
    assert quantity.source == "fitted to a test"


def test_the_source_of_what_was_fitted_as_built_is_the_commissioning_recording_alone(recording):
    sheet = load_rig()
    new, later = (Experiment(replace(recording.between(0.0, 30.0), path=path), sheet) for path in ("new", "later"))
    case = DriveCase([new], [later], sheet)
    path = next(p for p in case.paths if not p.startswith("measurement."))
    for as_built, source in ((True, "fitted to new"), (False, "fitted to new, later")):
        rig = case.rig_with(np.full(case.size, 0.1), [], np.full(case.size, 0.2), as_built=as_built)
        assert rig.quantities[path].source == source


def test_what_an_effect_wrote_has_the_spread_of_both(model):
    """A leakage ratio 1.2 of a leakage known to 0.2 of its tolerance: both are in the product, and what is shared cancels."""
    effect, theta, spread = EFFECTS["pump_1.leakage"], np.zeros(model.size), np.full(model.size, 0.2)
    acting = [(effect, 0, 0.2)]
    i = model.paths.index("pump_1.leakage")
    leakage, scale = model.rig["pump_1.leakage"], model.problem.scale[i]
    joint = np.diag([*spread**2, 0.03**2])

    def std(joint):
        return model.rig_written(theta, acting, spread, "fitted to a test", joint).quantities["pump_1.leakage"].std

    by_law = effect.law_error * 0.2 * leakage
    both = np.hypot(1.2 * 0.2 * scale, 0.03 * leakage)
    assert std(joint) == pytest.approx(np.hypot(both, by_law), rel=1e-3)
    assert std(None) == pytest.approx(np.hypot(1.2 * 0.2 * scale, by_law), rel=1e-3)
    joint[i, -1] = joint[-1, i] = -0.99 * 0.2 * 0.03
    assert std(joint) < 0.7 * std(np.diag(np.diagonal(joint)))


def test_held_out_samples_lie_behind_those_that_are_used_in_each_recording(model):
    held = HeldData.of(model)
    mask = held.mask()
    for experiment in model.experiments[1:]:
        for signal in experiment.signals.values():
            used, counts = signal.binning.bin >= 0, mask(signal)
            assert not (used & counts).any()
            assert not counts.any() or signal.time[counts].min() > experiment.held_from
            assert not used.any() or signal.time[used].max() <= experiment.used_until
        assert mask(experiment.signals["speed"]).any()
        assert experiment.used_until < experiment.held_from < experiment.duration
        assert f"from {experiment.held_from:.0f} s to its end at {experiment.duration:.0f} s" in held.words


def test_held_runs_are_those_of_the_field(model):
    held, theta = HeldData.of(model), np.zeros(model.size)
    runs = held.run(theta, [(OFFSET, 0, 1e5)])
    assert len(runs) == len(held.signals()) == 2
    drawn = traces(held, runs[0], runs[0], dict.fromkeys(held.signals()[0], 1.6))
    for trace in drawn.values():
        assert (np.diff(trace.time) >= 0.0).all() and trace.time.size == trace.measured.size
    assert set(held.axes(theta, [])) >= {"speed, rad/s", "tank oil temperature, K"}


def test_a_validation_recording_is_held_whole(recording):
    sheet = load_rig()
    model = DirectDrive([], [Experiment(recording, sheet)], sheet, [Experiment(recording.between(0.0, 40.0), sheet)])
    held = HeldData.of(model)
    (signals,) = held.signals()
    assert "(validation, the whole of it)" in held.words
    for signal in signals.values():
        np.testing.assert_array_equal(held.mask()(signal), signal.binning.bin >= 0)
    (run,) = held.run(np.zeros(model.size), [(OFFSET, 0, 1e5)])
    (plain,) = held.run(np.zeros(model.size), [])
    assert not np.array_equal(run["pressure_rod_side"], plain["pressure_rod_side"])
