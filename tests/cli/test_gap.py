"""The verb gap around an engine that is given: what it passes on, writes, says and returns."""

import html
import json
import sys
import types
from dataclasses import replace

import jsonschema
import pytest
from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.cli.main import main
from ddh_twin_py.rig import load_rig
from support.made_diagnosis import KINDS, made_diagnosis


@pytest.fixture
def engine(monkeypatch):
    """The engine replaced by one that keeps what it was asked and answers with `answer`."""
    module = types.ModuleType("ddh_twin_py.diagnosis.of_bags")
    module.asked, module.answer = [], made_diagnosis("explained", seconds=60.0)

    def diagnose(field, commissioning, validation, rig, without=(), only=(), progress=None, namespace=None):
        module.asked.append((field, commissioning, validation, rig, tuple(without)))
        module.namespace = namespace
        if isinstance(module.answer, Exception):
            raise module.answer
        progress(0.5)
        return module.answer

    module.diagnose, module.stage_of = diagnose, lambda share: "weighing effects"
    monkeypatch.setitem(sys.modules, "ddh_twin_py.diagnosis.of_bags", module)
    return module


@pytest.fixture
def case(tmp_path):
    for role in ("field", "commissioning"):
        (tmp_path / "case" / role).mkdir(parents=True)
        (tmp_path / "case" / role / "metadata.yaml").write_text("")
    return tmp_path / "case"


@pytest.mark.parametrize("kind", KINDS)
def test_every_verdict_is_written_and_is_a_success(kind, engine, case, tmp_path, shared_dir, capsys):
    engine.answer = made_diagnosis(kind, seconds=60.0)
    out = tmp_path / "deep" / "out"
    assert main(["gap", str(case), "--json", str(out / "g.json"), "--html", str(out / "g.html")]) == 0
    data = json.loads((out / "g.json").read_text(), parse_constant=pytest.fail)
    jsonschema.validate(data, json.loads((shared_dir / "gap_report.schema.json").read_text()))
    assert data.pop("end_matter")["data_split"] == f"Held out: {engine.answer.report['held_out']}."
    assert data == json.loads(json.dumps(engine.answer.report))
    assert engine.answer.sentence in html.unescape((out / "g.html").read_text())
    said, _ = capsys.readouterr()
    assert engine.answer.sentence in " ".join(said.split())


def test_a_case_folder_and_a_rig_reach_the_engine(engine, case, tmp_path):
    rig = tmp_path / "rig.yaml"
    rig.write_text("rig_id: press_7\n")
    assert main(["gap", str(case), "--rig", str(rig), "--without", "load.mass", "--without", "pump_1.leakage", "--quiet"]) == 0
    ((field, commissioning, validation, given, without),) = engine.asked
    assert (field, commissioning, validation) == ((case / "field",), case / "commissioning", None)
    assert given.rig_id == "press_7" and without == ("load.mass", "pump_1.leakage")


def test_a_namespace_chooses_among_the_rigs_of_a_bag(engine, case):
    assert main(["gap", str(case), "--namespace", "/crane", "--quiet"]) == 0
    assert engine.namespace == "/crane"


@pytest.mark.parametrize("more", [["--quiet"], ["--json", "-"]])
def test_data_that_are_lost_are_told_on_standard_error_where_there_is_no_summary(more, engine, case, capsys):
    engine.answer.report["notes"] = ["field: metadata.yaml cannot be read; recovered 512 messages", "no temperature"]
    engine.answer = replace(engine.answer, damage=["field: half of it is lost"])
    assert main(["gap", str(case), *more]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
    assert said == ["warning: field: half of it is lost", "warning: field: metadata.yaml cannot be read; recovered 512 messages"]


def test_json_to_standard_output_is_alone_there(engine, case, capsys):
    assert main(["gap", str(case), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "explained"
    assert main(["gap", str(case), "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_the_rig_file_is_the_diagnosis_and_can_be_read(engine, case, tmp_path):
    path = tmp_path / "out.yaml"
    assert main(["gap", str(case), "-o", str(path), "--quiet"]) == 0
    assert load_rig(path).quantities == engine.answer.rig.quantities
    assert engine.answer.sentence in path.read_text()


@pytest.mark.parametrize(("nameless", "said"), [(True, "and not in this file; its parameters are those of the commissioning"), (False, "")])
def test_a_rig_file_without_the_cause_says_so(nameless, said, engine, case, tmp_path, capsys):
    engine.answer = replace(made_diagnosis("unknown", seconds=60.0), nameless=nameless)
    path = tmp_path / "out.yaml"
    assert main(["gap", str(case), "-o", str(path)]) == 0
    assert ("What acts is unknown" in path.read_text()) is nameless and said in path.read_text()
    assert ("careful, what acts is unknown and not in it" in capsys.readouterr().err) is nameless
    load_rig(path)


@pytest.mark.parametrize("nameless", [True, False])
def test_why_one_has_to_be_careful_with_a_rig_file_is_said(nameless, engine, case, tmp_path, capsys):
    damage = ["commissioning and field may be interchanged: x was recorded 3 days later", "field: half of it is lost"]
    engine.answer = replace(engine.answer, damage=damage, nameless=nameless)
    path = tmp_path / "out.yaml"
    assert main(["gap", str(case), "-o", str(path)]) == 0
    doubts = "; ".join([*["what acts is unknown and not in it"] * nameless, *damage])
    assert f"{path}: rig {engine.answer.rig.rig_id}; careful, {doubts}\n" in capsys.readouterr().err


def test_a_bag_with_control_characters_in_its_name_has_one_line_of_the_rig_file(engine, case, tmp_path):
    odd = case.rename(tmp_path / "a\n\x1b[31mb")
    assert main(["gap", str(odd), "-o", str(tmp_path / "out.yaml"), "--quiet"]) == 0
    assert load_rig(tmp_path / "out.yaml").quantities == engine.answer.rig.quantities
    assert "/a\\n\\x1b[31mb/field, " in (tmp_path / "out.yaml").read_text().splitlines()[0]


@pytest.mark.parametrize("more", [[], ["--quiet"]])
def test_no_rig_file_comes_of_recordings_that_allow_no_answer(more, engine, case, tmp_path, capsys):
    engine.answer = made_diagnosis("insufficient", seconds=60.0)
    path = tmp_path / "out.yaml"
    assert main(["gap", str(case), "-o", str(path), *more]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if str(path) in line]
    assert said == [f"{path}: not written, as the recordings allow no answer"] and not path.exists()


@pytest.mark.parametrize("given, expected", [
    (["gap"], "FIELD"),
    (["gap", "nowhere"], "nowhere does not exist"),
    (["gap", "CASE", "--validation", "nowhere"], "nowhere does not exist"),
    (["gap", "CASE", "--without", "pump_1.leak"], "no effect 'pump_1.leak'; the nearest is 'pump_1.leakage'"),
    (["gap", "CASE", "--rig", "no_rig.yaml"], "no_rig.yaml"),
    (["gap", "CASE", "--html", "CASE"], "is a folder and no file"),
])
def test_what_cannot_be_used_is_one_line_before_any_work(given, expected, engine, case, capsys):
    given = [str(case) if word == "CASE" else word for word in given]
    try:
        code = main([*given, "--quiet"])
    except SystemExit as left:
        code = left.code
    assert code == 2 and not engine.asked
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert expected in line


def test_a_bag_that_the_engine_refuses_is_one_line(engine, case, tmp_path, capsys):
    engine.answer = BagError(f"{case}/field: topic /ddh/drive/telemetry is missing")
    assert main(["gap", str(case), "--quiet", "--json", str(tmp_path / "g.json")]) == 2
    assert capsys.readouterr().err == f"ddh-twin gap: error: {case}/field: topic /ddh/drive/telemetry is missing\n"
    assert not (tmp_path / "g.json").exists()


@pytest.mark.parametrize("given", [["gap", "CASE/no\nwhere"], ["gap", "CASE/field", "--json", "CASE/field/metadata.yaml"]])
def test_an_error_gives_no_orders_to_the_terminal(given, case, tmp_path, capsys):
    odd = str(case.rename(tmp_path / "a\x1b[2Jb"))
    try:
        assert main([word.replace("CASE", odd) for word in given]) == 2
    except SystemExit as left:
        assert left.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "/a\\x1b[2Jb/" in line and line.isprintable()


def test_interrupted_nothing_is_written(engine, case, tmp_path, capsys):
    def interrupted(*args, **more):
        raise KeyboardInterrupt

    engine.diagnose = interrupted
    assert main(["gap", str(case), "--quiet", "--html", str(tmp_path / "g.html")]) == 130
    assert capsys.readouterr().err == "ddh-twin gap: interrupted\n" and not (tmp_path / "g.html").exists()


def test_a_disk_that_is_full_for_one_output_leaves_the_others(engine, case, tmp_path, capsys, monkeypatch):
    from ddh_twin_py.report.page.document import Document

    def full(self, path):
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr(Document, "write", full)
    page, numbers, rig = (str(tmp_path / name) for name in ("x.html", "x.json", "x.yaml"))
    assert main(["gap", str(case), "--html", page, "--json", numbers, "-o", rig]) == 2
    said = capsys.readouterr()
    assert f"error: {page}: No space left on device" in said.err and engine.answer.sentence.split()[0] in said.out
    assert json.loads((tmp_path / "x.json").read_text())["verdict"] == "explained"
    assert load_rig(rig).quantities == engine.answer.rig.quantities
