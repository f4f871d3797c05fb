"""The electro-hydraulic actuator: reading, free run, balance and diagnosis, on made records; and on real ones where they are there."""

import os
from pathlib import Path

import numpy as np
import pytest
from ddh_twin_py.real_rigs.diagnose import found_by, rounds
from ddh_twin_py.real_rigs.eha import recordings
from ddh_twin_py.real_rigs.eha.balance import balance, ideal
from ddh_twin_py.real_rigs.eha.model import BORE, DESCRIPTION, EFFECTS, NOISE, Stroke
from ddh_twin_py.real_rigs.eha.recordings import STEP, Actuation
from ddh_twin_py.real_rigs.eha.study import figures
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.study import RecordingsError

SHARED = Path(os.environ.get("DDH_SHARED", "../shared")) / "data" / "real" / "eha"
NONE = np.zeros(len(DESCRIPTION.parameters))


def blank(load=2, seconds=24.0):
    """Out, hold, in, hold; twice, the second time half as far."""
    time = STEP * (np.arange(round(seconds / STEP)) + 0.5)
    speed = np.interp(time, [0, 2, 2.3, 5, 5.3, 8, 8.3, 11, 11.3, 14, 14.3, 15.5, 15.8, 18, 18.3, 19.7, 20, 24],
                      [0, 0, 120, 120, 0, 0, -85, -85, 0, 0, 120, 120, 0, 0, -85, -85, 0, 0])
    valve = np.where(time < 7.9, 1.0, np.where(time < 13.8, -1.0, np.where(time < 17.9, 1.0, -1.0)))
    zero = np.zeros(time.size)
    return Actuation(f"made_{load}", load, 1, time, speed, zero, np.full(time.size, 5e5), np.full(time.size, 5e5), valve)


def made(acting=(), load=2, seed=0, noise=0.3):
    """A record that the model makes itself under a load of its own."""
    rng = np.random.default_rng(seed)
    run = Stroke(blank(load))
    run._starts[:] = False  # nothing to put back to
    run.asked, run.at_speed = np.array([5e5 + 1e6 * load, 4e5 + 5e5 * load]), np.array([0.0135, 0.0135])
    said = run.predict(RigModel(DESCRIPTION, [run]).record(0, NONE, acting))
    read = {name: values + rng.normal(0.0, noise * NOISE[name], values.size) for name, values in said.items()}
    own = run.record
    return Actuation(own.name, load, 1, own.time, own.speed, read["position"], read["pressure_a"], read["pressure_b"], own.valve)


def effect_of(name):
    return next(effect for effect in EFFECTS if effect.id == name)


@pytest.fixture(scope="module")
def run():
    return Stroke(made())


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.id)
def test_neutral_is_the_baseline_and_a_departure_moves_it(run, effect):
    model = RigModel(DESCRIPTION, [run])
    plain = model.run(NONE)[0]
    for law in range(len(effect.laws)):
        for name, values in model.run(NONE, [(effect, law, 0.0)])[0].items():
            np.testing.assert_array_equal(values, plain[name])
        moved = model.run(NONE, [(effect, law, effect.step)])[0]
        assert all(np.isfinite(values).all() for values in moved.values())
        assert any(np.sqrt(np.mean((moved[name] - plain[name]) ** 2)) > 0.02 * NOISE[name] for name in plain)


def test_oil_is_kept(run):
    """What the pump gives is what the rod takes, where nothing leaks and sides are stiff."""
    record = DESCRIPTION.record()
    record["leakage"], record["bulk_modulus"], record["air"] = 0.0, 1e14, 0.0
    position = run.predict(record)["position"]
    out = (run.record.time > 1.5) & (run.record.time < 7.0)
    pumped = float(np.sum(record["displacement"] * run.record.speed[out]) / (2.0 * np.pi) * STEP)
    assert np.pi / 4.0 * BORE**2 * (position[out][-1] - position[out][0]) == pytest.approx(pumped, rel=0.01)


def test_a_leak_lets_the_loaded_side_sink_and_shortens_the_stroke(run):
    record = DESCRIPTION.record()
    plain = run.predict(record)
    record["leakage"] *= 20.0
    leaking = run.predict(record)
    hold = (run.record.time > 6.0) & (run.record.time < 7.5)
    assert leaking["pressure_a"][hold][-1] < plain["pressure_a"][hold][-1] - 1e5
    assert leaking["position"][hold].max() < plain["position"][hold].max()


def test_balance_of_the_right_parameters_is_small(run):
    acting = [(effect_of("cylinder.rod_diameter"), 0, 0.008), (effect_of("side.compliance"), 0, 1.5e-12)]
    other = Stroke(made(acting, noise=0.05))
    model = RigModel(DESCRIPTION, [other])
    left, moving = balance(other.record, ideal()[0])
    right, _ = balance(other.record, model.record(0, NONE, acting)[0])
    used = moving & np.isfinite(left)
    assert used.sum() > 50 and np.sqrt(np.mean(right[used] ** 2)) < 0.5 * np.sqrt(np.mean(left[used] ** 2))
    assert np.isnan(left).sum() >= 3  # the valve switched


def test_what_acts_is_found_on_several_loads_and_shrinks_another():
    acting = [(effect_of("cylinder.rod_diameter"), 0, 0.008), (effect_of("side.compliance"), 0, 1.5e-12)]
    runs = [Stroke(made(acting, load, load)) for load in (1, 3)]
    outcomes = rounds(RigModel(DESCRIPTION, runs, [Stroke(made(acting, 5, 5))]), most=2)
    assert {"cylinder.rod_diameter", "side.compliance"} <= set(found_by(outcomes))
    last = outcomes[-1]
    before = RigModel(DESCRIPTION, runs).record(0, NONE)
    rows = figures([Stroke(made(acting, 2, 9))], before, last.model.record(0, last.plain.theta), "made")
    assert [row.what.split()[0] for row in rows] == ["position", "piston-side", "rod-side", "flow", "flow"]
    assert rows[0].after < 0.5 * rows[0].before and rows[3].after < 0.7 * rows[3].before


def test_nothing_is_told_of_the_baseline():
    outcomes = rounds(RigModel(DESCRIPTION, [Stroke(made((), load, load)) for load in (1, 3)], [Stroke(made((), 5, 5))]))
    assert found_by(outcomes) == [] and outcomes[0].verdict == "no_gap"


def test_reading_says_what_is_wrong_in_one_line(tmp_path):
    with pytest.raises(RecordingsError, match="exp_data_1_1.npz: no such file; get the set from the public repository ivliev123"):
        recordings.read(tmp_path, (1,))
    size = 2000
    arrays = {name: np.zeros(size) for name in ("pressure_a", "pressure_b", "speed", "position", "valve_command")}
    np.savez(tmp_path / "exp_data_1_1.npz", time=np.arange(size, dtype=float), **arrays)
    (record,) = recordings.read(tmp_path, (1,), (1,))
    assert record.time.size == size // 5 and record.time[1] - record.time[0] == pytest.approx(STEP)
    np.savez(tmp_path / "exp_data_1_2.npz", time=np.arange(size, dtype=float))
    with pytest.raises(RecordingsError, match="there is no pressure_a; needed are time"):
        recordings.read(tmp_path, (1,), (2,))
    np.savez(tmp_path / "exp_data_1_3.npz", time=3.0 * np.arange(size), **arrays)
    with pytest.raises(RecordingsError, match="time advances by 3 ms, allowed is a whole part of 5 ms"):
        recordings.read(tmp_path, (1,), (3,))
    broken = arrays | {"speed": np.r_[np.nan, np.zeros(size - 1)]}
    np.savez(tmp_path / "exp_data_1_4.npz", time=np.arange(size, dtype=float), **broken)
    with pytest.raises(RecordingsError, match="exp_data_1_4.npz: speed, sample 0: a value that is not finite"):
        recordings.read(tmp_path, (1,), (4,))
    np.savez(tmp_path / "exp_data_1_4.npz", time=np.arange(7.0), **arrays)
    with pytest.raises(RecordingsError, match="time has shape .7,., allowed are 1000 or more samples"):
        recordings.read(tmp_path, (1,), (4,))
    (tmp_path / "exp_data_1_4.npz").write_bytes((tmp_path / "exp_data_1_1.npz").read_bytes()[:3000])
    with pytest.raises(RecordingsError, match="not a whole .npz archive"):
        recordings.read(tmp_path, (1,), (4,))
    assert not recordings.present(tmp_path)


@pytest.mark.skipif(not recordings.present(SHARED), reason=f"no recordings in {SHARED}")
def test_real_records_are_balanced_better_with_a_thicker_rod_and_soft_sides():
    left = {}
    for name, p in (("sheet", ideal()), ("found", DESCRIPTION.record())):
        if name == "found":
            p["displacement"], p["rod"], p["line"], p["skew"] = 1.35e-6, 0.028, 1.3e-12, 0.03
        parts = [balance(record, p[0]) for record in recordings.read(SHARED, (1, 3, 5))]
        left[name] = 1e6 * np.sqrt(np.mean(np.concatenate([v[m & np.isfinite(v)] for v, m in parts]) ** 2))
    assert left["sheet"] == pytest.approx(0.80, abs=0.03) and left["found"] < 0.43
