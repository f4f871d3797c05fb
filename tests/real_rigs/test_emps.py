"""The axis model, its reading and its study, on made sets; and on the real one where it is there."""

import numpy as np
import pytest
from ddh_twin_py.real_rigs.emps import inverse
from ddh_twin_py.real_rigs.emps.model import DESCRIPTION, EFFECTS, HELD_SHARE, Axis
from ddh_twin_py.real_rigs.emps.recordings import IDENTIFICATION, PERIOD, PULSES, STEP, present, read
from ddh_twin_py.real_rigs.emps.study import run
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.signals import noise_of_repeats
from ddh_twin_py.real_rigs.study import RecordingsError
from scipy.io import loadmat, savemat
from support.documented import shown
from support.real_sets import effect_of, emps_record, write_emps

pytestmark = pytest.mark.long
NONE = np.zeros(3)


@pytest.fixture(scope="module")
def axis():
    return Axis(emps_record(periods=1), 0.3)


@pytest.fixture(scope="module")
def model(axis):
    return RigModel(DESCRIPTION, [axis])


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.id)
def test_neutral_is_the_baseline_and_a_departure_moves_it(model, effect):
    plain = model.run(NONE)[0]["force"]
    for law in range(len(effect.laws)):
        np.testing.assert_array_equal(model.run(NONE, [(effect, law, 0.0)])[0]["force"], plain)
        moved = model.run(NONE, [(effect, law, effect.step)])[0]["force"]
        assert np.isfinite(moved).all() and np.sqrt(np.mean((moved - plain) ** 2)) > 0.05


def test_force_of_a_steady_motion_is_that_of_the_friction(axis):
    """Energy: over a period in which the axis comes back to rest, the work of the motor is that of the friction."""
    record = DESCRIPTION.record()
    position, force = axis.simulate(record)
    velocity = np.gradient(position, STEP)
    work = float(np.sum(force * velocity) * STEP)
    lost = float(np.sum(record["coulomb"][0] * np.abs(velocity) + record["viscous"][0] * velocity**2) * STEP)
    assert work == pytest.approx(lost, rel=0.01)


def test_the_axis_sticks_below_the_dry_friction():
    record = DESCRIPTION.record()
    made = emps_record(periods=1)
    still = Axis(made.__class__(**{**made.__dict__, "reference": np.zeros(made.time.size), "position": np.full(made.time.size, 1e-5)}), 0.3)
    position, force = still.simulate(record)
    assert np.ptp(position) == 0.0 and 0.0 < abs(force[100]) < record["coulomb"][0]


def test_a_stiff_transmission_is_nearly_rigid(axis):
    record = DESCRIPTION.record()
    rigid = axis.simulate(record)[1]
    record["compliance"] = 1e-10
    assert np.sqrt(np.mean((axis.simulate(record)[1] - rigid) ** 2)) < 0.3


def test_inverse_model_of_its_own_motion_leaves_little():
    record = emps_record(periods=2)
    motion = inverse.motion_of(record)
    p = RigModel(DESCRIPTION, [Axis(record, 0.3)]).record(0, np.array([-0.2, 0.1, 0.1]))
    right = inverse.relative(inverse.force_error(motion, p), motion)
    p["mass"] *= 1.1
    assert right < 3.0 and inverse.relative(inverse.force_error(motion, p), motion) > right
    fitted = inverse.least_squares(motion, False)
    assert fitted[:3] == pytest.approx([94.0, 210.0, 21.0], rel=0.05) and abs(fitted[3]) < 0.5


def test_noise_of_repeats(axis):
    assert noise_of_repeats(emps_record().force[PERIOD:], PERIOD) == pytest.approx(0.3, rel=0.05)


def test_a_study_finds_what_acts_and_sizes_it_on_the_other_record(tmp_path):
    acting = [(effect_of(DESCRIPTION, "friction.viscous_direction"), 0, -80.0)]
    shares = []
    study = run(write_emps(tmp_path, acting), shares.append)
    assert study.found == ["friction.viscous_direction"]
    held = [row for row in study.rows if "held out" in row.split]
    assert {row.unit for row in held} == {"%", "µm"} and all(row.after < 0.7 * row.before for row in held if "authors" not in row.what)
    assert all(control.passed for control in study.controls) and len(study.controls) == 4
    assert shares[-1] == 1.0 and shares == sorted(shares)


def other(folder, **values):
    """The file with pulses, some variables of which are other ones."""
    there = {key: value for key, value in loadmat(folder / PULSES).items() if not key.startswith("__")}
    savemat(folder / PULSES, there | values)


@pytest.mark.parametrize("spoil, said", [
    (lambda f: (f / PULSES).unlink(), "no such file; the set is at nonlinearbenchmark.org"),
    (lambda f: (f / PULSES).write_bytes(b"no matlab file at all, by far"), "cannot be read as a MATLAB file"),
    (lambda f: (f / PULSES).write_bytes((f / IDENTIFICATION).read_bytes()), "pulses_N is missing"),
    (lambda f: (f / PULSES).write_bytes((f / PULSES).read_bytes()[:100_000]), "cannot be read as a MATLAB file"),
    (lambda f: other(f, qm=np.r_[np.nan, np.zeros(24959)]), "qm holds a value that is no number"),
    (lambda f: other(f, qm=np.zeros(7)), "qm has 7 samples, t has 24960"),
    (lambda f: other(f, t=np.zeros(5)), "5 samples, needed are 12480 or more"),
    (lambda f: other(f, t=0.01 * np.arange(24960)), "t advances by 0.01 s, allowed is 0.001 s"),
    (lambda f: other(f, kp=np.zeros((0, 0))), "kp is empty"),
    (lambda f: other(f, gtau=-1.0), "gtau is -1, allowed is more than 0"),
    (lambda f: other(f, qg="word"), "qg holds <U4, allowed are numbers"),
])
def test_a_set_that_cannot_be_used_is_one_line(tmp_path, spoil, said):
    folder = write_emps(tmp_path) / "emps"
    spoil(folder)
    with pytest.raises(RecordingsError, match=said) as error:
        read(tmp_path, PULSES)
    assert str(folder / PULSES) in str(error.value) and "\n" not in str(error.value)


def test_pulses_are_what_the_command_has_beyond_the_controller(tmp_path):
    write_emps(tmp_path)
    record = read(tmp_path, PULSES)
    assert set(np.round(np.unique(record.pulses), 0)) == {0.0, 70.0}
    assert not read(tmp_path, IDENTIFICATION).pulses.any()


def test_the_real_set(shared_dir, repo_root):
    data = shared_dir / "data" / "real"
    if not present(data):
        pytest.skip(f"no recordings of the EMPS in {data}")
    study = run(data)
    rows = {(row.what, row.split): row for row in study.rows}
    assert "friction.viscous_direction" in study.found
    theirs = next(row for (what, split), row in rows.items() if "authors" in what and "used" in split)
    assert theirs.before == pytest.approx(4.08, abs=0.1) and theirs.after == pytest.approx(3.11, abs=0.1)
    for row in study.rows:
        assert row.after < row.before, row
        assert shown(repo_root / "docs" / "real_rigs.md", row), row
    assert all(control.passed for control in study.controls)
    first = read(data, IDENTIFICATION)
    assert Axis(first, 0.4, HELD_SHARE).signals["force"].held_from < first.time[-1]
