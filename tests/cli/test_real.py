"""`ddh-twin real` on a made set: pages, table, JSON, and errors in one line."""

import csv
import io
import json
import shutil
from contextlib import redirect_stderr, redirect_stdout

import pytest
from ddh_twin_py.cli.main import main
from ddh_twin_py.real_rigs.cascaded_tanks.model import DESCRIPTION
from support.real_sets import effect_of, write_tanks


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    acting = [(effect_of(DESCRIPTION, "upper_tank.overflow"), 0, 0.12)]
    return write_tanks(tmp_path_factory.mktemp("real"), acting)


@pytest.fixture(scope="module")
def answered(data, tmp_path_factory):
    """Exit code, folder and console of one run over three sets, of which one alone can be used."""
    folder = tmp_path_factory.mktemp("several")
    sets, out = folder / "sets", folder / "out"
    shutil.copytree(data / "cascaded_tanks", sets / "cascaded_tanks")
    (sets / "emps").mkdir()
    (sets / "emps" / "DATA_EMPS.mat").write_bytes(b"MATLAB 5.0 MAT-file" + bytes(200))
    (sets / "eha").mkdir()
    said, err = io.StringIO(), io.StringIO()
    with redirect_stdout(said), redirect_stderr(err):
        code = main(["real", "--data", str(sets), "--out", str(out), "--json", str(folder / "all.json")])
    return code, out, said.getvalue(), err.getvalue()


def test_pages_table_and_json_agree(answered):
    _, out, said, _ = answered
    (study,) = json.loads((out.parent / "all.json").read_text())
    assert study["rig"] == "cascaded_tanks" and study == json.loads((out / "cascaded_tanks.json").read_text())
    page = (out / "cascaded_tanks.html").read_text()
    assert "upper tank: overflow" in page and "<figure" in page and "http" not in page.split("</style>")[-1].split("<script")[0]
    with open(out / "real.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(study["rows"]) and all(row["found"] == " + ".join(study["found"]) for row in rows)
    assert study["sentence"].split(";")[0] in " ".join(said.split())


@pytest.mark.parametrize("words, said", [
    (["real", "cascaded_tank", "--data", "{data}"], "no rig 'cascaded_tank'; the nearest is 'cascaded_tanks'"),
    (["real", "emps", "--data", "{data}"], "DATA_EMPS.mat: no such file; the set is at nonlinearbenchmark.org"),
    (["real", "--data", "{data}/nowhere"], "is no folder"),
    (["real", "--data", "{data}/cascaded_tanks"], "holds recordings of no rig"),
    (["real", "--data", "{data}", "--out", "{data}/cascaded_tanks/dataBenchmark.csv"], "dataBenchmark.csv is no folder"),
    (["real", "--data", "{data}", "--out", "{data}/cascaded_tanks/dataBenchmark.csv/out"], "dataBenchmark.csv is no folder"),
    (["real", "--data", "{data}", "--out", "/proc/out"], "--out: '/proc/out/real.csv' cannot be written"),
    (["real", "--data", "{data}", "--out", "{data}/out", "--json", "{data}/out/cascaded_tanks.json"], "--json and --out both write to"),
])
def test_what_cannot_be_done_is_one_line(data, capsys, words, said):
    assert main([word.format(data=data) for word in words]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if not line.startswith(("loading", "emps"))]
    assert len(lines) == 1 and lines[0].startswith("ddh-twin real: error: ") and said.format(data=data) in lines[0]
    assert not (data / "out").exists()


def test_a_set_that_cannot_be_used_does_not_stop_the_others(answered):
    code, out, said, err = answered
    assert code == 2 and "cascaded_tanks: " in said
    wrong = [line for line in err.splitlines() if "error" in line]
    assert [line.split(": ")[2] for line in wrong] == ["emps", "eha"] and "zema: no recordings in" in err
    assert "DATA_EMPS.mat: cannot be read" in wrong[0] and "exp_data_1_1.npz: no such file" in wrong[1]
    assert sorted(path.name for path in out.iterdir()) == ["cascaded_tanks.html", "cascaded_tanks.json", "real.csv"]
