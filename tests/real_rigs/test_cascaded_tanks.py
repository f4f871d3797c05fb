"""The tanks' model, their reading and their study, on made sets; and on the real one where it is there."""

import numpy as np
import pytest
from ddh_twin_py.real_rigs.cascaded_tanks.model import DESCRIPTION, EFFECTS, Tanks
from ddh_twin_py.real_rigs.cascaded_tanks.recordings import IDENTIFICATION, STEP, TEST, TankRecord, present, read
from ddh_twin_py.real_rigs.cascaded_tanks.study import run
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.study import RecordingsError
from support.documented import shown
from support.real_sets import effect_of, tank_record, write_tanks

pytestmark = pytest.mark.long
NONE = np.zeros(len(DESCRIPTION.parameters))
FILE = "dataBenchmark.csv"


@pytest.fixture(scope="module")
def model():
    return RigModel(DESCRIPTION, [Tanks(tank_record())])


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.id)
def test_neutral_is_the_baseline_and_a_departure_moves_it(model, effect):
    plain = model.run(NONE)[0]["level"]
    for law in range(len(effect.laws)):
        np.testing.assert_array_equal(model.run(NONE, [(effect, law, 0.0)])[0]["level"], plain)
        x = effect.highest if np.isfinite(effect.highest) else effect.step
        moved = model.run(NONE, [(effect, law, x)])[0]["level"]
        assert np.isfinite(moved).all() and np.abs(moved - plain).max() > 0.05


def test_water_is_kept():
    """What the pump brings is in the tanks or left by the lower outlet."""
    record = DESCRIPTION.record()
    run_ = Tanks(TankRecord("made", np.full(400, 3.0), np.zeros(400)))
    upper, lower = run_.levels(record)
    p = record[0]
    brought = STEP * 3.0 * p["pump"] * np.arange(400)
    out = STEP * p["outlet"] * np.concatenate([[0.0], np.cumsum(0.5 * (np.sqrt(lower[1:]) + np.sqrt(lower[:-1])))])
    np.testing.assert_allclose(upper + lower - upper[0] - lower[0], brought - out, atol=0.02)


def test_steady_levels_are_torricellis():
    record = DESCRIPTION.record()
    upper, lower = Tanks(TankRecord("made", np.full(3000, 2.0), np.zeros(3000))).levels(record)
    level = (2.0 * record["pump"][0] / record["outlet"][0]) ** 2
    assert upper[-1] == pytest.approx(level, rel=1e-3) and lower[-1] == pytest.approx(level, rel=1e-3)


def test_a_rim_is_never_exceeded_and_shape_effects_keep_the_flow_in_the_middle(model):
    record = model.record(0, NONE, [(effect_of(DESCRIPTION, "upper_tank.overflow"), 0, 0.125)])
    upper, _ = model.runs[0].levels(record)
    assert upper.max() == pytest.approx(8.0)
    steady = Tanks(TankRecord("made", np.full(4000, 3.0), np.zeros(4000)))
    plain = DESCRIPTION.record()
    plain["outlet"] = 3.0 * plain["pump"] / np.sqrt(5.0)
    for name, x in (("outlet.exponent", 0.1), ("outlet.head", 2.0), ("pump.threshold", 0.5), ("pump.curvature", 0.1)):
        acted = plain.copy()
        effect_of(DESCRIPTION, name).laws[0](acted, x)
        assert steady.levels(acted)[1][-1] == pytest.approx(5.0, rel=1e-3)


def test_a_study_finds_what_acts_and_sizes_it_on_the_other_record(tmp_path):
    acting = [(effect_of(DESCRIPTION, "upper_tank.overflow"), 0, 0.12)]
    study = run(write_tanks(tmp_path, acting))
    assert study.found == ["upper_tank.overflow"] and "upper level" in study.sentence
    test = next(row for row in study.rows if "held out" in row.split)
    assert test.after < 0.5 * test.before and test.samples == 1024
    assert all(control.passed for control in study.controls)


def test_a_study_of_plain_tanks_finds_nothing(tmp_path):
    study = run(write_tanks(tmp_path))
    assert study.found == [] and [o.verdict for o in study.rounds] == ["no_gap"]


@pytest.mark.parametrize("spoil, said", [
    (lambda f: f.unlink(), "no such file; the set is at nonlinearbenchmark.org"),
    (lambda f: f.write_text(f.read_text().replace("yVal", "zVal")), "column yVal is missing"),
    (lambda f: f.write_text(""), "column uVal is missing; there are none"),
    (lambda f: f.write_text(f.read_text().replace("\n", "\n1,2,3,x,\n", 1)), "column yVal, row 1: 'x' is no number"),
    (lambda f: f.write_text(f.read_text().replace("\n", "\n1,nan,3,4,\n", 1)), "column uVal, row 1: 'nan' is no number"),
    (lambda f: f.write_text("".join(f.read_text().splitlines(keepends=True)[:40])), "column uVal has 39 rows, needed are 100 or more"),
    (lambda f: f.write_bytes(f.read_bytes()[:-30]), "column .Val, row 102[34]: .* is no number"),
    (lambda f: f.write_bytes(bytes(range(256)) * 40), "column uVal is missing"),
])
def test_a_set_that_cannot_be_used_is_one_line(tmp_path, spoil, said):
    file = write_tanks(tmp_path) / "cascaded_tanks" / FILE
    spoil(file)
    with pytest.raises(RecordingsError, match=said) as error:
        read(tmp_path, TEST)
    assert str(file) in str(error.value) and "\n" not in str(error.value)


def test_reading_one_record_looks_at_nothing_of_the_other(tmp_path):
    file = write_tanks(tmp_path) / "cascaded_tanks" / FILE
    file.write_text(file.read_text().replace('"uVal"', '"other"').replace('"yVal"', '"another"'))
    assert read(tmp_path, IDENTIFICATION).level.size == 1024


def test_the_real_set(shared_dir, repo_root):
    data = shared_dir / "data" / "real"
    if not present(data):
        pytest.skip(f"no recordings of the cascaded tanks in {data}")
    study = run(data)
    assert "upper_tank.overflow" in study.found and "upper level" in study.sentence
    for row in study.rows:
        assert row.after < 0.75 * row.before, row
        assert shown(repo_root / "docs" / "real_rigs.md", row), row
    assert all(control.passed for control in study.controls)
