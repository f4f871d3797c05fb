"""An effect of no catalogue: told as unknown, learned as a term of the model, written into a rig file that says so."""

import pytest
from ddh_twin_py.gap.diagnose import Recordings, diagnose
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.writer import write_rig
from ddh_twin_py.twin.duty import load_duty
from ddh_twin_py.twin.rehearsal import rehearse
from support.simulated import DUTY

pytestmark = pytest.mark.long

HEAT = 30.0
SENSORS = ["motor_winding", "motor_housing", "tank_oil"]


@pytest.fixture(scope="module")
def diagnosis():
    """A heater at the motor, whose winding was not warm before; the one effect that is asked about has nothing to do with it."""
    rig, duty = load_rig(), load_duty(DUTY / "paper_cycle.yaml")
    heated = rig.with_values({"learned.motor_heat": HEAT})
    field, before = (rehearse(r, duty, 300.0, SENSORS) for r in (heated, rig))
    validation = rehearse(heated, load_duty(DUTY / "mixed.yaml"), 240.0, SENSORS)
    return diagnose(Recordings([field], before, validation), rig, only=("sensor.time_skew",))


def test_the_term_has_the_size_of_what_acts_and_shrinks_the_gap_of_held_out_data(diagnosis):
    assert diagnosis.report["verdict"] == "unknown"
    assert (diagnosis.report["unknown"]["component"], diagnosis.report["unknown"]["domain"]) == ("motor", "thermal")
    gap = diagnosis.report["gap"]
    assert gap["before"] > 3.0 and gap["after"] < 0.6 * gap["before"]
    housing = diagnosis.report["shrink"]["temperature/motor_housing"]  # where it acts
    assert housing["before"] > 8.0 * housing["noise"] and housing["after"] < 1.6 * housing["noise"]
    assert any(note.startswith("a learned term (learned.motor_heat") for note in diagnosis.report["notes"])
    assert diagnosis.rig["learned.motor_heat"] == pytest.approx(HEAT, rel=0.15)
    assert diagnosis.rig["learned.motor_heat_by_speed"] == 0.0


def test_the_rig_file_marks_it_and_is_read_again(diagnosis, tmp_path):
    quantity = diagnosis.rig.quantities["learned.motor_heat"]
    assert quantity.source.startswith("learned, cause unknown")
    write_rig(tmp_path / "rig.yaml", diagnosis.rig, "of a test")
    again = load_rig(tmp_path / "rig.yaml")
    assert again["learned.motor_heat"] == pytest.approx(quantity.value)
    assert "learned, cause unknown" in (tmp_path / "rig.yaml").read_text()
