"""Machine descriptions: what is read, what is refused."""

import pytest
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.machine import MachineError, bounds_of, load_machine


def test_the_115u2c_has_a_source_for_every_value_and_notes_for_known_quantities_alone():
    machine = load_machine()
    assert machine.machine_id == "115U2C"
    assert all(entry.source.split(":")[0] in {"paper", "frame", "physical", "assumption"} for entry in machine.entries.values())
    assert set(machine.notes) <= set(load_rig().quantities)


def test_a_partial_file_changes_only_what_it_names_and_brings_its_own_notes(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text(
        "machine_id: mine\nwinding:\n  fill: {value: 0.38, unit: '1', source: cut open}\n"
        "notes:\n  motor.thermal.yoke_capacity: >-\n    weighed\n    twice\n"
    )
    mine, reference = load_machine(file), load_machine()
    assert (mine.machine_id, mine["winding.fill"], mine.entries["winding.fill"].source) == ("mine", 0.38, "cut open")
    assert {path for path in mine.entries if mine[path] != reference[path]} == {"winding.fill"}
    assert dict(mine.notes) == {"motor.thermal.yoke_capacity": "weighed twice"}


@pytest.mark.parametrize("text, expected", [
    ("stator:\n  bor: {value: 0.05}\n", "stator.bor: no such entry; the nearest is 'stator.bore'"),
    ("stator:\n  bore: {value: 58, unit: mm}\n", "stator.bore: unit is 'mm', this entry is in 'm'"),
    ("stator:\n  bore: {value: 58, unit: m}\n", "stator.bore: value is 58 m, allowed are 0.0001 to 2 m; is it in the right unit?"),
    ("stator:\n  bore: {value: wide, unit: m}\n", "stator.bore: value is 'wide', a finite number is needed"),
    ("stator:\n  bore: {value: .inf, unit: m}\n", "stator.bore: value is inf"),
    ("stator:\n  bore: {value: true, unit: m}\n", "stator.bore: value is True"),
    ("stator:\n  bore: {value: 0.05}\n", "stator.bore: unit is missing, this entry is in 'm'"),
    ("winding:\n  fill: {value: 0.3, value: 0.4}\n", "winding.fill.value: given twice, in lines 2 and 2"),
    ("stator:\n  bore: 0.05\n", "stator.bore: found 0.05, expected {value, unit, source}"),
    ("stator: 3\n", "stator: found 3"),
    ("[1]\n", "holds a list; a machine description is a mapping of sections"),
    ("a: [\n", "is not YAML (line"),
    ("machine_id: [1]\n", "machine_id: found [1], a name is needed"),
    ("notes: [1]\n", "notes: a mapping"),
    ("winding:\n  fill: {value: 0.9}\n", "winding.fill: value is 0.9, allowed are 0.1 to 0.75"),
    ("stator:\n  slots: {value: 18.5}\n", "stator.slots: value is 18.5, a whole number is needed"),
    ("stator:\n  slots: {value: 20}\n", "stator.slots: value is 20, three phases need a multiple of 3"),
    ("winding:\n  turns_per_phase: {value: 140}\n", "with 18 slots the conductors per slot are 46.6667, not a whole"),
    ("stator:\n  slot_depth: {value: 0.03, unit: m}\n",
     "stator.slot_depth: value is 0.03 m, between bore and outer diameter is room for 0.022 m"),
    ("stator:\n  tooth_width: {value: 0.02, unit: m}\n", "stator.tooth_width: value is 0.02 m, no slot is left"),
    ("rotor:\n  magnet_thickness: {value: 0.02, unit: m}\n", "rotor.magnet_thickness: value is 0.02 m, nothing is left"),
    ("housing:\n  across_flats: {value: 0.1, unit: m}\n", "housing.across_flats: value is 0.1 m, the stator has 0.102 m"),
    ("housing:\n  body_length: {value: 0.1, unit: m}\n", "housing.body_length: value is 0.1 m, core and end windings are longer"),
])
def test_what_is_refused_is_named(tmp_path, text, expected):
    file = tmp_path / "odd.yaml"
    file.write_text(text)
    with pytest.raises(MachineError) as error:
        load_machine(file)
    assert str(error.value).startswith(str(file)) and expected in str(error.value), error.value


def test_a_missing_file(tmp_path):
    with pytest.raises(MachineError, match="no such machine description"):
        load_machine(tmp_path / "none.yaml")


def test_values_are_checked_when_changed_in_a_program():
    machine = load_machine()
    assert machine.with_values({"winding.fill": 0.3})["winding.fill"] == 0.3
    with pytest.raises(MachineError, match="stator.slot_depth"):
        machine.with_values({"stator.bore": 0.2})


def test_every_entry_of_the_reference_lies_strictly_inside_its_bounds_or_at_a_natural_end():
    for path, entry in load_machine().entries.items():
        low, high = bounds_of(path)
        assert low < entry.value < high or entry.value in (0.0, 1.0), path
