"""Cases on disk: bags that the project reads, a truth that fits them, nothing of it in the bags."""

import numpy as np
import pytest
import yaml
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.gap_bench import making
from ddh_twin_py.gap_bench.bench import make_bench
from ddh_twin_py.gap_bench.duties import drawn
from ddh_twin_py.gap_bench.making import make
from ddh_twin_py.gap_bench.plan import PlanError, Planned
from ddh_twin_py.gap_bench.recordings import recording_of
from ddh_twin_py.gap_bench.sealing import seal, verify
from ddh_twin_py.plant.machine import Machine, build
from ddh_twin_py.plant.sensors import SENSORS, Instruments, measure
from ddh_twin_py.rig import load_rig

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("bench")
    planned = Planned("case_0001", "single", "moderate", ("pump_1.leakage",), 1, True, 5)
    make(planned, out, load_rig())
    return out, yaml.safe_load((out / "truth" / "case_0001.yaml").read_text())


def test_effect_is_as_large_as_its_level(made):
    (effect,) = made[1]["effects"]
    assert effect["effect"] == "pump_1.leakage"
    assert effect["worst_rise"] == pytest.approx(5.0, rel=0.07)
    assert effect["value"] > effect["nominal"] == 1.0


def test_bags_are_read_without_a_finding(made):
    out, truth = made
    for part, shortest in (("commissioning", 590.0), ("field", 590.0), ("validation", 530.0)):
        recording = read_recording(out / "cases" / "case_0001" / part)
        assert recording.findings == []
        assert recording.rig.rig_id == "case_0001"
        assert recording.span[1] > shortest
        assert set(recording.temperatures) == set(truth["sensors"])


def test_made_case_is_left_alone(made):
    out, _ = made
    file = out / "truth" / "case_0001.yaml"
    before = file.stat().st_mtime_ns
    make(Planned("case_0001", "none", "", (), 0, True, 9), out, load_rig())
    assert file.stat().st_mtime_ns == before


def test_twin_that_knows_the_rig_is_left_near_the_noise():
    """What the plant's other laws leave to a twin with the plant's own numbers."""
    sheet, rng = load_rig(), np.random.default_rng(2)
    machine, duty = build(sheet, rng), drawn(rng, 400.0, 150.0, 20.0, warm=False)
    tools = Instruments.drawn(sheet, machine.rig["sensors.temperature.time_constant"], rng)
    course = machine.run(duty.exercise, [], duty.drive_time, duty.hydraulic_time)
    readings = measure(course, tools, duty.exercise.ambient, SENSORS, 0.5, rng)
    experiment = Experiment(recording_of(readings, "rig", 150.0, 10**18), sheet)
    known = {f"measurement.{name}_offset": zero for name, zero in tools.zeros.items() if name != "ambient"}
    known |= dict(zip(("measurement.pressure_piston_side_offset", "measurement.pressure_rod_side_offset"), tools.pressure_zeros,
                      strict=True))
    known["load.payload_mass"] = sheet["load.payload_mass"] * machine.payload_ratio
    predicted = experiment.predict(experiment.parameters(machine.rig.with_values(known)), 2.5e-4)
    left = {}
    for name, signal in experiment.signals.items():
        off = (signal.measured - predicted[name])[signal.time > 5.0]
        left[name] = np.sqrt(np.nanmean(off**2)) / signal.noise
    assert all(0.4 < value < 2.3 for value in left.values()), left
    assert 0.9 < np.sqrt(np.mean(np.square(list(left.values())))) < 1.4


def test_bench_is_made_sealed_and_not_made_twice(tmp_path):
    refused = []

    def meanwhile(share):
        with pytest.raises(PlanError, match="another ddh-twin gap-bench is making cases there; wait for it, or") as error:
            make_bench(tmp_path, 1, 2, ("none",))
        refused.append(str(error.value))

    assert make_bench(tmp_path, 1, 2, ("none",), progress=meanwhile) == []
    assert len(refused) == 1 and str(tmp_path) in refused[0] and "\n" not in refused[0]
    assert verify(tmp_path) == ["case_0001"]
    assert make_bench(tmp_path, 1, 2, ("none",)) == []
    with pytest.raises(PlanError, match="use another folder"):
        make_bench(tmp_path, 2, 2, ("none",))


def test_of_a_case_whose_plant_leaves_the_numbers_nothing_is_left(tmp_path, monkeypatch):
    monkeypatch.setattr(making, "drawn", lambda rng, _, *further: drawn(rng, 40.0, *further))
    run = Machine.run

    def astray(self, exercise, faults, *times):
        course = run(self, exercise, faults, *times)
        if (tmp_path / "cases" / "case_0002" / "commissioning").exists():
            course.drive[-1, 0] = np.nan
        return course

    monkeypatch.setattr(Machine, "run", astray)
    make(Planned("case_0001", "none", "", (), 0, True, 9), tmp_path, load_rig())
    with pytest.raises(PlanError, match="case_0002: field: the plant left the numbers"):
        make(Planned("case_0002", "none", "", (), 0, True, 5), tmp_path, load_rig())
    seal(tmp_path)
    assert verify(tmp_path) == ["case_0001"] and not (tmp_path / "cases" / "case_0002").exists()


def test_a_folder_that_holds_something_else_is_no_place_for_a_bench(tmp_path):
    (tmp_path / "metadata.yaml").write_text("of a bag")
    with pytest.raises(PlanError, match="metadata.yaml: is of no bench, .* use an empty folder or a new one"):
        make_bench(tmp_path, 1, 2, ("none",))
    assert [entry.name for entry in tmp_path.iterdir()] == ["metadata.yaml"]
