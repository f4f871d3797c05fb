"""`ddh-twin real` on a made set: pages, table, JSON, and errors in one line."""

import csv
import json

import pytest
from ddh_twin_py.cli.main import main
from ddh_twin_py.real_rigs.cascaded_tanks.model import DESCRIPTION
from support.real_sets import effect_of, write_tanks


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    acting = [(effect_of(DESCRIPTION, "upper_tank.overflow"), 0, 0.12)]
    return write_tanks(tmp_path_factory.mktemp("real"), acting)


def test_pages_table_and_json_agree(data, tmp_path, capsys):
    out, numbers = tmp_path / "out", tmp_path / "all.json"
    assert main(["real", "--data", str(data), "--out", str(out), "--json", str(numbers)]) == 0
    said, err = capsys.readouterr()
    (study,) = json.loads(numbers.read_text())
    assert study["rig"] == "cascaded_tanks" and study == json.loads((out / "cascaded_tanks.json").read_text())
    page = (out / "cascaded_tanks.html").read_text()
    assert "upper tank: overflow" in page and "<figure" in page and "http" not in page.split("</style>")[-1].split("<script")[0]
    with open(out / "real.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(study["rows"]) and all(row["found"] == " + ".join(study["found"]) for row in rows)
    assert study["sentence"].split(";")[0] in " ".join(said.split())
    assert "emps: no recordings in" in err


@pytest.mark.parametrize("words, said", [
    (["real", "cascaded_tank", "--data", "{data}"], "no rig 'cascaded_tank'; the nearest is 'cascaded_tanks'"),
    (["real", "emps", "--data", "{data}"], "DATA_EMPS.mat: no such file; the set is at nonlinearbenchmark.org"),
    (["real", "--data", "{data}/nowhere"], "is no folder"),
    (["real", "--data", "{data}/cascaded_tanks"], "holds recordings of no rig"),
    (["real", "--data", "{data}", "--out", "{data}/cascaded_tanks/dataBenchmark.csv"], "is no folder"),
])
def test_what_cannot_be_done_is_one_line(data, capsys, words, said):
    assert main([word.format(data=data) for word in words]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if not line.startswith(("loading", "emps"))]
    assert len(lines) == 1 and lines[0].startswith("ddh-twin real: error: ") and said in lines[0]
