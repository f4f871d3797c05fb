"""The ZeMA rig: reading, features, network and conditions, on a rig simulated by other equations; and on the real one where it is there."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from ddh_twin_py.real_rigs.diagnose import found_by, rounds
from ddh_twin_py.real_rigs.fit import by_steps
from ddh_twin_py.real_rigs.rig_model import RigModel
from ddh_twin_py.real_rigs.study import RecordingsError
from ddh_twin_py.real_rigs.zema import conditions, network, recordings
from ddh_twin_py.real_rigs.zema.catalogue import ACCUMULATOR, COOLER, DESCRIPTION, EFFECTS, PUMP, VALVE
from ddh_twin_py.real_rigs.zema.features import features
from ddh_twin_py.real_rigs.zema.model import Cycles
from ddh_twin_py.real_rigs.zema.recordings import Record
from support.zema_rig import Faults, simulate

N = 240
KNOWN = np.r_[150:160, 190:200, 230:240]
SHARED = Path(os.environ.get("DDH_SHARED", "../shared")) / "data" / "real" / "zema"


@pytest.fixture(scope="module")
def faults():
    cycle = np.arange(N)
    return Faults(np.where(((cycle // 30) % 2 == 0) & (cycle < 120), 0.3, 0.47), np.where(cycle // 10 % 3 == 1, 0.03, 0.0) * (cycle < 140),
                  np.where((cycle // 30) % 2 == 1, 0.4, 0.0) * (cycle < 150),
                  np.where((cycle // 20) % 2 == 1, 50.0, 64.0) * (cycle < 150) + 64.0 * (cycle >= 150), jitter=0.002, slack=0.3)


@pytest.fixture(scope="module")
def record(faults):
    return Record(simulate(faults), KNOWN)


@pytest.fixture(scope="module")
def fitted(record):
    model = RigModel(DESCRIPTION, [Cycles(record, block) for block in record.blocks()])
    return model.record(0, by_steps(model))


@pytest.fixture(scope="module")
def found(record, fitted):
    return conditions.conditions(features(record.signals), fitted[0], np.isin(np.arange(N), KNOWN))


def write(folder, record, cycles=KNOWN):
    folder.mkdir(parents=True, exist_ok=True)
    blank = {name: np.zeros((record.cycles, 60)) for name in recordings.MEASURED}
    np.savez(folder / "sensors_1hz.npz", **(blank | record.signals))
    np.savetxt(folder / "calibration_cycles.txt", cycles, fmt="%d")
    return folder


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda e: e.id)
def test_neutral_is_the_baseline_and_a_departure_moves_it(record, effect):
    model = RigModel(DESCRIPTION, [Cycles(record, slice(150, 160))])
    plain = model.run(np.zeros(model.size))[0]
    for law in range(len(effect.laws)):
        for name, values in model.run(np.zeros(model.size), [(effect, law, 0.0)])[0].items():
            np.testing.assert_array_equal(values, plain[name])
        moved = model.run(np.zeros(model.size), [(effect, law, effect.step)])[0]
        assert any(not np.array_equal(moved[name], plain[name]) for name in plain)


def test_features_are_what_the_rig_does(record, faults):
    """Switching times against the simulated lag, stored oil against the gas law."""
    f = features(record.signals)
    late = f.opening - f.opening[KNOWN].mean()
    assert np.median(late[faults.lag > 0.0]) == pytest.approx(0.03, abs=0.004)
    gas = f.stored / network.stored(f)
    ratio = np.median(gas[faults.gas < 60.0]) / np.median(gas[KNOWN])
    assert ratio == pytest.approx(50.0 / 64.0, abs=0.04)


def test_a_locked_load_says_nothing(record):
    signals = {name: values.copy() for name, values in record.signals.items()}
    signals["PS1"][5, 30:40], signals["FS1"][5, 30:40] = 190.0, 1.0
    f = features(signals)
    assert not f.working[5, 2] and f.working[5, 1] and np.isnan(f.stored[5, 1:3]).all() and np.isfinite(f.stored[5, [0, 3]]).all()
    assert f.pump[5] == pytest.approx(features(record.signals).pump[5], abs=0.1)


def test_heat_is_balanced_in_the_steady_state(record, fitted):
    f = features(record.signals)
    p, n = fitted[0], 4000
    still = replace(f, **{name: np.repeat(getattr(f, name)[-1:], n, axis=0) for name in vars(f)})
    oil = network.temperatures(still, p)[-1]
    cooled = network.HEAT * still.cooling[-1] * (oil[2] - oil[3])
    assert cooled + p["wall"] * (oil[2] - p["air"]) == pytest.approx(p["heat_share"] * still.power[-1], rel=1e-3)


def test_conditions_follow_the_faults(found, faults):
    away = np.ones(N, dtype=bool)
    away[:3] = False  # the oil begins cold
    truth = {"cooler": faults.effectiveness < 0.4, "valve": faults.lag > 0.0, "pump_leakage": faults.leakage > 0.0,
             "accumulator": faults.gas < 60.0}
    for component, worse in truth.items():
        assert np.mean((found.worse[component] > 0.5)[away] == worse[away]) > 0.95, component
        sign = -1.0 if component == "pump_leakage" else 1.0
        estimate = sign * found.estimate[component]
        assert estimate[~worse & away].mean() > estimate[worse & away].mean()
    right = [(verdict == "none") == (not any(worse[t] for worse in truth.values())) and (verdict == "none" or truth[verdict][t])
             for t, verdict in enumerate(found.verdict)]
    assert np.mean(np.array(right)[away]) > 0.95


def test_table_has_a_line_for_each_cycle(found):
    lines = conditions.as_csv(found).splitlines()
    assert lines[0] == "cycle,cooler,valve,accumulator,pump_leakage,p_cooler,p_valve,p_pump_leakage,p_accumulator,verdict"
    assert len(lines) == N + 1 and lines[-1].startswith(f"{N - 1},") and lines[-1].endswith(",none")
    assert all(0.0 <= float(cell) <= 1.0 for cell in lines[17].split(",")[5:9])


def test_what_is_not_seen_is_left_empty_and_its_prior_kept(record, fitted):
    signals = {name: np.tile(values[KNOWN[:10]], (6, 1)) for name, values in record.signals.items()}
    same = conditions.conditions(features(signals), fitted[0], np.arange(60) >= 40)
    assert same.estimate["valve"] is None and np.all(same.worse["valve"] == conditions.PRIOR_WORSE)
    assert set(same.verdict) == {"none"} and ",,," in conditions.as_csv(same).splitlines()[1]


@pytest.mark.parametrize(("cycles", "effect"), [(slice(11, 20), VALVE), (slice(92, 100), PUMP), (slice(140, 149), ACCUMULATOR),
                                                (slice(1, 10), COOLER), (slice(170, 180), None)])
def test_the_engine_finds_the_fault_of_a_run_of_cycles(record, cycles, effect):
    outcomes = rounds(RigModel(DESCRIPTION, [Cycles(record, cycles, 3)], commissioning=[Cycles(record, b) for b in record.blocks()]))
    said = found_by(outcomes)
    assert (effect in said) if effect else not said


def test_reading_says_what_is_wrong_in_one_line(tmp_path, record):
    with pytest.raises(RecordingsError, match="sensors_1hz.npz: no such file; get the set from UCI"):
        recordings.read(tmp_path)
    read = recordings.read(write(tmp_path / "zema", record))
    np.testing.assert_array_equal(read.known, KNOWN)
    assert [b.start for b in read.blocks()] == [150, 190, 230] and read.cycles == N
    write(tmp_path / "far", record, [0, N])
    with pytest.raises(RecordingsError, match=f"allowed are two or more of 0 to {N - 1}"):
        recordings.read(tmp_path / "far")
    short = {name: values[:, :50] for name, values in record.signals.items()}
    write(tmp_path / "short", Record(short, KNOWN))
    with pytest.raises(RecordingsError, match=r"allowed is \(cycles, 60\)"):
        recordings.read(tmp_path / "short")


@pytest.mark.parametrize("cycles, change, said", [
    ([], {}, "no cycles, allowed are two or more"),
    ([5, 100], {}, "no more than 1 cycles in a row, needed are 3 or more"),
    (KNOWN, {"FS1": np.zeros((N, 60))}, "FS1 reads 0 L/min in most samples, allowed is more than 0"),
    (KNOWN, {"TS1": np.full((N, 60), np.nan)}, "TS1 has a value that is not finite in cycle 0"),
    (KNOWN, {"PS1": np.array([["a"] * 60] * N)}, "PS1 holds <U1, allowed are numbers"),
])
def test_what_cannot_be_a_record_is_refused(tmp_path, record, cycles, change, said):
    with pytest.raises(RecordingsError, match=said):
        recordings.read(write(tmp_path, Record(record.signals | change, KNOWN), cycles))


def test_a_damaged_archive_is_one_line(tmp_path, record):
    file = write(tmp_path, record) / "sensors_1hz.npz"
    whole = file.read_bytes()
    for content in (whole[: len(whole) // 2], b"", b"no archive"):
        file.write_bytes(content)
        with pytest.raises(RecordingsError, match="not a whole .npz archive") as error:
            recordings.read(tmp_path)
        assert str(file) in str(error.value) and "\n" not in str(error.value)
    file.write_bytes(whole)
    (tmp_path / "calibration_cycles.txt").write_text("150\nlast one\n")
    with pytest.raises(RecordingsError, match="calibration_cycles.txt: .*allowed is one cycle number a line"):
        recordings.read(tmp_path)
    few = {name: values[:20] for name, values in record.signals.items()}
    np.savez(file, **{name: np.ones((20, 60)) for name in recordings.MEASURED} | few)
    with pytest.raises(RecordingsError, match="20 cycles, needed are 30 or more"):
        recordings.read(tmp_path)


@pytest.mark.skipif(not recordings.present(SHARED), reason=f"no recordings in {SHARED}")
def test_the_real_rig_read_and_fitted_to_its_known_cycles():
    real = recordings.read(SHARED)
    model = RigModel(DESCRIPTION, [Cycles(real, block) for block in real.blocks()])
    p = model.record(0, by_steps(model))[0]
    assert 15.0 < p["air"] < 28.0 and 0.3 < p["effectiveness"] < 0.6 and 0.09 < p["closing"] < 0.11
    f = features({name: values[real.known] for name, values in real.signals.items()})
    errors = f.flow - network.flows(f, f.temperature[:, :2].mean(axis=1), p)
    assert np.sqrt(np.mean(errors**2)) < 0.03
