"""Every reader of a YAML file says in one line what is not there."""

import pytest
from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.exchange.mapping import read_mapping
from ddh_twin_py.nodes.parameter_file import ParameterFileError, read_parameter_file
from ddh_twin_py.rig import RigError, load_rig
from ddh_twin_py.rig.machine import MachineError, load_machine
from ddh_twin_py.twin.duty import DutyError, load_duty

READERS = [
    (load_rig, RigError, "a rig file is a mapping of sections"),
    (load_machine, MachineError, "a machine description is a mapping of sections"),
    (load_duty, DutyError, "a duty file is a mapping of entries"), (read_mapping, ExchangeError, "a mapping file is a mapping of entries"),
    (read_parameter_file, ParameterFileError, "a parameter file is a mapping of nodes with ros__parameters"),
]


@pytest.mark.parametrize(("read", "error_type", "words"), READERS)
@pytest.mark.parametrize(("text", "held"), [
    ("", "is empty"), ("# a comment\n", "is empty"), ("- a\n", "holds a list"), ("[]\n", "holds a list"),
    ("text\n", "holds 'text'"), ("7\n", "holds 7"),
])
def test_every_reader_says_what_a_file_holds_that_is_no_mapping(read, error_type, words, text, held, tmp_path):
    file = tmp_path / "own file.yaml"
    file.write_text(text)
    with pytest.raises(error_type) as error:
        read(file)
    assert str(error.value) == f"{file}: {held}; {words}"


@pytest.mark.parametrize(("read", "error_type", "text", "words"), [
    (load_machine, MachineError, "stator: {bore: {value: , unit: m}}", "stator.bore: value is missing, a finite number is needed"),
    (load_machine, MachineError, "stator: {bore: {value: 0.06, unit: }}", "stator.bore: unit is missing, this entry is in 'm'"),
    (load_machine, MachineError, "stator: {bore: }", "stator.bore: found nothing, expected {value, unit, source}"),
    (load_machine, MachineError, "stator:", "stator: found nothing, expected a mapping of entries"),
    (load_duty, DutyError, "cycle:", "cycle: found nothing, a list of segments is needed"),
    (load_duty, DutyError, "cycle: [lift: ]", "cycle[0].lift: found nothing, needed are speed_rpm, to_m"),
    (load_duty, DutyError, "cycle: [dwell: {duration_s: }]", "cycle[0].dwell.duration_s: value is missing, a finite number is needed"),
    (load_duty, DutyError, "cycle: [dwell: {duration_s: 1}]\npayload_kg:", "payload_kg: value is missing, a finite number is needed"),
    (load_duty, DutyError, "cycle: [dwell: {duration_s: 1}]\nambient_degC:", "ambient_degC: value is missing, a finite number is needed"),
    (read_mapping, ExchangeError, "columns:", "columns: found nothing, a mapping of signals is needed, such as"),
    (read_mapping, ExchangeError, "columns: {speed_command: }", "columns.speed_command: found nothing, a mapping with column and unit"),
    (read_mapping, ExchangeError, "columns: {speed_command: {column: , unit: rpm}}", "columns.speed_command.column: value is missing"),
    (read_mapping, ExchangeError, "columns: {speed_command: {column: n, unit: rpm}}\ntime: {column: }", "time.column: value is missing"),
])
def test_every_reader_names_a_value_that_is_missing(read, error_type, text, words, tmp_path):
    file = tmp_path / "own.yaml"
    file.write_text(text)
    with pytest.raises(error_type) as error:
        read(file)
    assert str(error.value).startswith(f"{file}: {words}") and "\n" not in str(error.value)
