"""CSV logs become bags that the twin takes; what is wrong is named by file, line and column."""

import json
import os
import tracemalloc

import numpy as np
import pytest
import yaml
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.cli.main import main
from ddh_twin_py.exchange.errors import ExchangeError
from ddh_twin_py.exchange.import_log import import_logs
from ddh_twin_py.exchange.log_file import read_log
from ddh_twin_py.exchange.mapping import Dialect, read_mapping
from ddh_twin_py.exchange.units import to_inside

LOG = "t;n_set;n;p;oil\n0,00;500;498,5;12,5;30\n0,01;500;n/a;12,6;\n0,02;;;;31\n"
MAPPING = {
    "time": {"column": "t", "unit": "s", "since": "2026-05-01T08:00:00Z"},
    "rig": {"rig_id": "press_7", "oil_grade": "ISO VG 32", "payload_mass_kg": 120},
    "csv": {"decimal": ",", "missing": ["n/a"]},
    "columns": {
        "speed_command": {"column": "n_set", "unit": "rpm"}, "speed": {"column": "n", "unit": "rpm", "factor": -1},
        "pressure_rod_side": {"column": "p", "unit": "bar"}, "temperature/tank_oil": {"column": "oil", "unit": "degC", "every_s": 0.015},
    },
}


@pytest.fixture
def files(tmp_path):
    """Writes a log and a mapping; gives their paths."""
    def write(log=LOG, **changes):
        paths = tmp_path / "log.csv", tmp_path / "mapping.yaml"
        paths[0].write_bytes(log if isinstance(log, bytes) else log.encode())
        paths[1].write_text(yaml.safe_dump({**MAPPING, **changes}))
        return paths
    return write


def refused(paths) -> str:
    with pytest.raises(ExchangeError) as said:
        import_logs([paths[0]], read_mapping(paths[1]))
    assert "\n" not in str(said.value)
    return str(said.value).replace(str(paths[0]), "LOG").replace(str(paths[1]), "MAP")


def test_values_units_and_stamps(files):
    log, mapping = files()
    recording = import_logs([log], read_mapping(mapping))
    assert recording.epoch_ns == 1_777_622_400_000_000_000 and str(recording.rig) == "press_7, ISO VG 32, payload 120 kg"
    np.testing.assert_allclose(recording.drive.time, [0.0, 0.01])
    np.testing.assert_allclose(recording.drive.column("speed"), [-498.5 * np.pi / 30, np.nan])
    np.testing.assert_allclose(recording.drive.column("speed_command"), 500 * np.pi / 30)
    assert np.isnan(recording.drive.column("torque")).all()
    np.testing.assert_allclose(recording.hydraulic.column("pressure_rod_side"), [12.5e5, 12.6e5])
    oil = recording.temperatures["tank_oil"]
    np.testing.assert_allclose(oil.time, [0.0, 0.02])
    np.testing.assert_allclose(oil.column("temperature"), [303.15, 304.15])


def test_a_recording_comes_back_as_it_was(short_bag, tmp_path, capsys):
    folder, bag = tmp_path / "samples", tmp_path / "again"
    assert main(["export", str(short_bag), "--telemetry", str(folder), "--quiet"]) == 0
    logs = sorted(str(path) for path in folder.glob("*.csv"))
    assert main(["import", *logs, "--mapping", str(folder / "mapping.yaml"), "-o", str(bag), "--quiet"]) == 0
    before, after = read_recording(short_bag), read_recording(bag)
    assert (before.rig, before.epoch_ns) == (after.rig, after.epoch_ns)
    for (topic, one), (same_topic, same) in zip(before.streams(), after.streams(), strict=True):
        assert topic == same_topic
        np.testing.assert_array_equal(one.time, same.time, err_msg=topic)
        np.testing.assert_array_equal(one.values, same.values, err_msg=topic)
    capsys.readouterr()
    verdicts = []
    for path in (short_bag, bag):
        assert main(["replay", str(path), "--json", "-", "--quiet"]) == 0
        data = json.loads(capsys.readouterr().out)
        verdicts.append((data["verdict"], data["temperatures"], data["signals"]))
    assert verdicts[0] == verdicts[1]


def test_logs_with_different_columns_and_parts_that_follow(files, tmp_path):
    mapping = read_mapping(files()[1])
    first, second, oil = (tmp_path / f"{name}.csv" for name in ("a", "b", "oil"))
    first.write_text("t;n_set;n;p\n0;100;100;1\n1;100;100;1\n")
    second.write_text("t;n_set;n;p\n2;200;200;2\n")
    oil.write_text("t;oil\n0,5;30\n1,5;31\n")
    recording = import_logs([first, second, oil], mapping)
    np.testing.assert_allclose(recording.drive.time, [0.0, 1.0, 2.0])
    np.testing.assert_allclose(recording.temperatures["tank_oil"].time, [0.5, 1.5])


def test_parts_are_put_in_order_of_time_however_they_are_given(files, tmp_path):
    """As a shell gives them: log_1, log_10, log_2."""
    _, mapping = files(columns={name: {"column": "n", "unit": "rad/s"} for name in ("speed", "speed_command")})
    logs = {k: tmp_path / f"log_{k}.csv" for k in (1, 10, 2)}
    for k, log in logs.items():
        log.write_text("t;n\n" + "".join(f"{k + i / 10};{k}\n".replace(".", ",") for i in range(10)))
    recording = import_logs(list(logs.values()), read_mapping(mapping))
    np.testing.assert_allclose(recording.drive.time, np.concatenate([k - 1 + np.arange(10) / 10 for k in (1, 2, 10)]))
    np.testing.assert_array_equal(recording.drive.column("speed"), np.repeat([1.0, 2.0, 10.0], 10))
    logs[2].write_text("t;n\n1,75;2\n3,0;2\n")
    with pytest.raises(ExchangeError, match=r"log_2.csv: drive/telemetry is told for 0.150 s by .*log_1.csv, too"):
        import_logs(list(logs.values()), read_mapping(mapping))


def test_columns_that_nobody_asked_for_take_no_memory(tmp_path):
    log = tmp_path / "wide.csv"
    log.write_text("t," + ",".join(f"c{k}" for k in range(200)) + "\n" + "".join(f"{i}," + "0.5," * 199 + "0.5\n" for i in range(2000)))
    tracemalloc.start()
    try:
        read = read_log(log, Dialect(), ["t", "c7"])
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert read.numbers("t")[-1] == 1999.0 and (read.numbers("c7") == 0.5).all() and read.cells.keys() == {"t", "c7"}
    assert most < 2e6, "all cells take 20 MB"


@pytest.mark.parametrize("unit, texts, expected_ns", [
    ("ns", ("1777622400000000001",), 1777622400000000001),
    ("s", ("1777622400.000000001",), 1777622400000000001),
    ("ms", ("1777622400000,25",), 1777622400000250000),
    ("iso8601", ("2026-05-01T10:00:00.5+02:00",), 1777622400500000000),
])
def test_times_keep_their_digits(files, unit, texts, expected_ns):
    log, mapping = files(f"t;n_set;n;p;oil\n{texts[0]};1;1;1;1\n", time={"column": "t", "unit": unit})
    assert import_logs([log], read_mapping(mapping)).epoch_ns == expected_ns


@pytest.mark.parametrize("log, said", [
    ("t;n_set;n;p;oil\n0;1;x7;1;1\n", "LOG: line 2, column 'n': value is 'x7'; a number is needed"),
    ("t;n_set;n;p;oil\n0;1;1;1;1\n\n1;1;1.5.1;1;1\n", "LOG: line 4, column 'n': value is '1.5.1'; a number is needed"),
    ("t;n_set;n;p;oil\nnoon;1;1;1;1\n", "LOG: line 2, column 't': value is 'noon'; a time in s is needed"),
    ("t;n_set;n;p;oil\n-3e9;1;1;1;1\n", "LOG: line 2, column 't': value is '-3e9'; with time.unit and time.since it lies before 1970"),
    ("t;n_set;n;p;oil\n;1;1;1;1\n", "LOG: line 2, column 't': value is ''; a time in s is needed"),
    ("t;n_set;n;p;oil\n0;1_0;1;1;1\n", "LOG: line 2, column 'n_set': value is '1_0'; a number is needed"),
    ("t;n_set;n;p;oil\n0;1;1\n", "LOG: line 2: has 3 of the 5 cells of the heading"),
    ("t;n_set;n;oil\n0;1;1;1\n",
     "LOG: line 1: no column 'p'; valid are t, n_set, n, oil (columns.pressure_rod_side of MAP)"),
    ("time;n_set;n;p;oil\n0;1;1;1;1\n", "LOG: line 1: no column 't'; the nearest is 'time'"),
    ("t;n_set;n;n;p;oil\n0;1;1;1;1;1\n", "LOG: line 1: 2 columns are named 'n'"),
    ("t;n_set;n;p;oil\n0;;;;\n", "LOG: no line has a value in any column of MAP"),
    ("", "LOG: has no line 1, where the names of the columns are"),
    ("t;n_set;n;p;öl\n".encode("latin-1"), "LOG: is not text in utf-8-sig"),
])
def test_a_log_that_cannot_be_used(files, log, said):
    assert refused(files(log)).startswith(said)


def test_a_decimal_comma_that_nobody_announced(files):
    said = refused(files("t;n_set;n;p;oil\n0;1;498,5;1;1\n", csv={"delimiter": ";"}))
    assert said == "LOG: line 2, column 'n': value is '498,5'; a number is needed; decimals with a comma: csv.decimal: ','"
    said = refused(files("t;n_set;n;p;oil\n0,5;1;498;1;1\n", csv={"delimiter": ";"}))
    assert said == "LOG: line 2, column 't': value is '0,5'; a time in s is needed; decimals with a comma: csv.decimal: ','"


@pytest.mark.parametrize("csv", [{"decimal": ","}, {"decimal": ",", "delimiter": ","}])
def test_commas_between_quoted_numbers_with_a_comma(csv, files):
    quoted = "t,n_set,n,p,oil\n" + '"0,00",500,"498,5","12,5",30\n"0,01","500,0",,"12,6",\n'
    recording = import_logs([files(quoted, csv=csv)[0]], read_mapping(files(quoted, csv=csv)[1]))
    np.testing.assert_allclose(recording.drive.time, [0.0, 0.01])
    np.testing.assert_allclose(recording.drive.column("speed"), [-498.5 * np.pi / 30, np.nan])
    np.testing.assert_allclose(recording.hydraulic.column("pressure_rod_side"), [12.5e5, 12.6e5])
    said = refused(files("t,n_set,n,p,oil\n0,00,500,498,12,30\n", csv=csv))  # 0 would be a time, and 00 a command
    assert said.startswith("LOG: line 2: has 6 cells and the heading 5; where the comma is csv.delimiter and csv.decimal, a number")


def test_a_name_of_digits_is_told_as_it_is_written_or_refused(files):
    log, mapping = files()
    mapping.write_text(mapping.read_text().replace("press_7", "007"))
    assert "'007' is no int: YAML takes a number that begins with 0 as octal; put a name in quotes" in refused((log, mapping))
    mapping.write_text(mapping.read_text().replace("007", "'007'"))
    assert import_logs([log], read_mapping(mapping)).rig.rig_id == "007"


def test_a_heading_that_is_not_cut_names_its_delimiter(files):
    said = refused(files("t,n_set,n,p,oil\n0,1,1,1,1\n", csv={"delimiter": ";"}))
    assert said == ("LOG: line 1: no column 't'; valid are t,n_set,n,p,oil (time.column of MAP); "
                    "its heading is one column, cut at ';' (csv.delimiter)")


def test_what_says_that_there_is_nothing_is_read_as_it_stands_in_the_log(files):
    log, mapping = files(LOG.replace("498,5", "-9999,0").replace("12,5", "-,-").replace("30\n", "-1,5\n"),
                         csv={"decimal": ",", "missing": ["n/a", "-9999,0", "-,-", -1.5]})
    recording = import_logs([log], read_mapping(mapping))
    assert np.isnan(recording.drive.column("speed")).all() and np.isfinite(recording.drive.column("speed_command")).all()
    np.testing.assert_allclose(recording.hydraulic.column("pressure_rod_side"), [12.6e5])
    np.testing.assert_allclose(recording.temperatures["tank_oil"].column("temperature"), [304.15])


@pytest.mark.parametrize("written", ["-9999", "-9999,0", "-9999,000", "-9,999e3"])
def test_a_number_that_says_that_there_is_nothing_is_meant_by_value(written, files):
    log, mapping = files(LOG.replace("498,5", written).replace("30\n", f"{written}\n"), csv={"decimal": ",", "missing": ["n/a", -9999, 0]})
    recording = import_logs([log], read_mapping(mapping))
    assert np.isnan(recording.drive.column("speed")).all() and recording.drive.time.size == 2  # the time 0 is a time
    np.testing.assert_allclose(recording.temperatures["tank_oil"].column("temperature"), [304.15])


@pytest.mark.parametrize("changes, said", [
    ({"colums": {}}, "MAP: colums: no entry 'colums'; the nearest is 'columns'"),
    ({"time": {"colunm": "t"}}, "MAP: time.colunm: no entry 'colunm'; the nearest is 'column'"),
    ({"time": {"column": "t", "unit": "sec"}}, "MAP: time.unit: no unit 'sec'; the nearest is"),
    ({"time": {"column": "t", "since": "yesterday"}}, "MAP: time.since: value is 'yesterday', a moment such as"),
    ({"time": {}}, "MAP: time.column is missing"),
    ({"columns": {"sped": {"column": "n", "unit": "rpm"}}}, "MAP: columns.sped: no signal 'sped'; the nearest is 'speed'"),
    ({"columns": {"speed": {"column": "n", "unit": "rmp"}}}, "MAP: columns.speed.unit: no unit 'rmp'; the nearest is 'rpm'"),
    ({"columns": {"speed": {"column": "n"}}}, "MAP: columns.speed: unit is missing; units of speed are rad/s, rpm"),
    ({"columns": {"speed": {"column": "n", "unit": "rpm", "variance_K2": 1}}}, "MAP: columns.speed.variance_K2: no entry"),
    ({"columns": {"speed": {"column": "n", "unit": "rpm", "factor": 0}}}, "MAP: columns.speed.factor: value is 0"),
    ({"columns": {"speed": {"column": "n", "unit": "rpm"}}}, "MAP: columns: speed_command is missing, and the twin is driven by it"),
    ({"columns": {}}, "MAP: columns: found {}, a mapping of signals is needed"),
    ({"rig": {"payload_mass_kg": -1}}, "MAP: rig.payload_mass_kg: value is -1 kg, allowed are above 0 to 100000 kg"),
    ({"csv": {"delimiter": "."}}, "MAP: csv.decimal and csv.delimiter are both '.'"),
    ({"csv": {"encoding": "undefined"}}, "MAP: csv.encoding: no encoding 'undefined'"),
    ({"csv": {"encoding": "utf8x"}}, "MAP: csv.encoding: no encoding 'utf8x'"),
    ({"csv": {"missing": [10**400]}}, "MAP: csv.missing: value is 1000"),
    ({"csv": {"header_line": 0}}, "MAP: csv.header_line: value is 0, a whole number from 1 on"),
])
def test_a_mapping_that_cannot_be_used(files, changes, said):
    assert refused(files(**changes)).startswith(said)


@pytest.mark.parametrize("value, unit, inside, expected", [
    (60.0, "rpm", "rad/s", 2 * np.pi), (1.0, "bar_absolute", "Pa", 100000.0 - 101325.0), (32.0, "degF", "K", 273.15),
    (1.0, "hp", "W", 745.7), (10.0, "mm/s", "m/s", 0.01), (1.0, "psi", "Pa", 6894.76), (2.0, "kN*m", "N*m", 2000.0),
])
def test_units(value, unit, inside, expected):
    assert to_inside(np.array([value]), unit, inside)[0] == pytest.approx(expected, rel=1e-5)


def test_a_wrong_unit_is_seen_afterwards(files, tmp_path, capsys):
    rows = "".join(f"{k / 100:.2f};500;{500 + 30 * np.sin(k / 20):.2f};{100 + np.sin(k):.2f};30\n".replace(".", ",") for k in range(4000))
    log, mapping = files("t;n_set;n;p;oil\n" + rows, columns={
        **MAPPING["columns"], "speed": {"column": "n", "unit": "rad/s"}})  # what the file has is rpm
    assert main(["import", str(log), "--mapping", str(mapping), "-o", str(tmp_path / "bag"), "--json", str(tmp_path / "told.json")]) == 0
    assert "rpm" in capsys.readouterr().err
    told = json.loads((tmp_path / "told.json").read_text())
    assert told["rig"]["rig_id"] == "press_7" and any(f["field"] == "speed" for f in told["findings"])


def test_the_example_is_a_mapping_that_works(tmp_path, capsys):
    assert main(["import", "--example"]) == 0
    text = capsys.readouterr().out
    (tmp_path / "mapping.yaml").write_text(text)
    mapping = read_mapping(tmp_path / "mapping.yaml")
    names = [mapping.time.column, *(rule.column for rule in mapping.columns)]
    (tmp_path / "log.csv").write_text(",".join(names) + "\n" + ",".join("1" for _ in names) + "\n")
    recording = import_logs([tmp_path / "log.csv"], mapping)
    assert recording.drive.column("electrical_power")[0] == 1000.0 and len(recording.temperatures) == 3
    assert main(["import", str(tmp_path / "log.csv"), "--example"]) == 0
    assert f"# columns of {tmp_path / 'log.csv'}: t, n_set, n," in capsys.readouterr().out


@pytest.mark.parametrize("argv, said", [
    ([], "no log was given; ddh-twin import --example"), (["log.csv"], "--mapping is missing"),
    (["log.csv", "--mapping", "m.yaml"], "-o is missing"),
    (["log.csv", "--mapping", "m.yaml", "-o", "new"], "m.yaml: no such mapping file"),
    (["log.csv", "./log.csv", "--mapping", "m.yaml", "-o", "new"], "./log.csv: is given twice; each log is read once"),
])
def test_what_the_verb_lacks(argv, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["import", *argv, "--quiet"]) == 2
    assert capsys.readouterr().err.startswith(f"ddh-twin import: error: {said}")


def test_a_log_that_is_no_regular_file_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "log.csv")
    for log, kind in ((tmp_path / "log.csv", "a named pipe"), ("/dev/zero", "a character device")):
        with pytest.raises(ExchangeError) as error:
            read_log(log, Dialect(), ["t"])
        assert str(error.value) == f"{log}: is {kind}, a regular file is needed"
