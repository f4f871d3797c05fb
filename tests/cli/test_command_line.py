"""What holds for every verb: options, outputs, colours, completion, exit codes, the pages that are made of them."""

import argparse
import json
import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest
from ddh_twin_py.cli.arguments import OUTPUTS, InputError, json_file, output_file, reads
from ddh_twin_py.cli.command_line_page import command_line_page
from ddh_twin_py.cli.exit_codes import EXIT_CODES, NO
from ddh_twin_py.cli.main import VERBS, build_parser, main
from ddh_twin_py.report.reference.message_page import message_page
from ddh_twin_py.report.reference.rig_sheet_page import rig_sheet_page
from ddh_twin_py.rig.files import did_you_mean


def parsers() -> dict[str, argparse.ArgumentParser]:
    (action,) = (a for a in build_parser()._actions if isinstance(a, argparse._SubParsersAction))
    return dict(action.choices)


@pytest.mark.parametrize("verb", ["gap", "fleet", "replay"])
def test_what_is_missing_is_said_with_where_an_example_is(verb, capsys):
    with pytest.raises(SystemExit) as left:
        main([verb])
    said = capsys.readouterr().err
    assert left.value.code == 2
    assert re.fullmatch(rf"ddh-twin {verb}: error: .* required: [A-Z]+ \(how: ddh-twin {verb} --help\)\n", said), said


@pytest.mark.parametrize("verb", VERBS)
def test_options_mean_the_same_in_every_verb(verb):
    parser = parsers()[verb]
    options = {name: action for action in parser._actions for name in action.option_strings}
    assert all(action.help for action in parser._actions), "an argument without help"
    assert all(re.fullmatch(r"-\w|--[a-z][a-z0-9-]*", name) for name in options), options.keys()
    assert "--json" in options
    if verb != "completion":
        assert "--quiet" in options
    for name, kind, metavar in (("--json", json_file, "FILE"), ("--html", output_file, "FILE"), ("--csv", output_file, "FILE")):
        if name in options:
            assert options[name].type is kind and options[name].metavar == metavar
    for name, metavar in (("--rig", "FILE"), ("--namespace", "NS"), ("--out", "FOLDER"), ("--jobs", "N"), ("--duty", None)):
        if name in options and metavar:
            assert options[name].metavar == metavar, (verb, name)
    if "-o" in options:
        assert options["-o"] is options["--output"] and options["-o"].type in OUTPUTS
    assert re.search(rf"^  ddh-twin {verb}( |$)", parser.epilog, re.MULTILINE), "no example"


NEEDS_DATA = {"real": "public recordings, which are not part of the repository"}


@pytest.mark.parametrize("verb", [verb for verb in VERBS if verb not in NEEDS_DATA])
def test_the_first_example_of_each_verb_works_in_a_fresh_checkout(verb, repo_root):
    line = next(line for line in parsers()[verb].epilog.splitlines() if line.startswith("  ddh-twin "))
    words = re.split(r"\s{2,}| > ", line.strip())[0].split()[1:]
    found = build_parser().parse_args(words)
    named = ("FILE", "BAG", "FIELD", "LOG", "FOLDER", "RIG.yaml")
    for action in parsers()[verb]._actions:
        given = getattr(found, action.dest, None)
        if action.metavar in named and action.type not in OUTPUTS and given != action.default:
            for path in [given] if isinstance(given, str) else given:
                assert (repo_root / path).exists() or path.startswith("out/"), f"{line.strip()}: {path} is not in the repository"


def test_the_commands_as_data(capsys):
    assert main(["completion", "bash", "--json", "-"]) == 0
    tree = json.loads(capsys.readouterr().out)
    assert list(tree) == list(VERBS)
    sources = next(one for one in tree["up"]["arguments"] if one["names"] == ["--source"])
    assert sources["choices"] == ["none", "bag", "simulation"]
    assert all(one["help"] for verb in tree.values() for one in verb["arguments"])


def test_the_example_of_each_verb_parses():
    """Every line of an example that is one command is understood; files need not be there."""
    parser = build_parser()
    for verb, child in parsers().items():
        lines = [line.strip() for line in child.epilog.splitlines() if line.startswith("  ddh-twin ")]
        for line in lines:
            words = re.split(r"\s{2,}| > ", line)[0].split()[1:]
            found, extra = parser.parse_known_args(words)
            assert found.verb == verb and not extra, line


@pytest.mark.parametrize("argv, said", [
    (["replay", "b", "--html", "r.x", "--json", "r.x"], "--html and --json both write to 'r.x'"),
    (["replay", "b", "--html", "r.x", "--json", "./r.x"], "--html and --json both write to './r.x'"),
    (["gap", "b", "--html", "r.x", "-o", "sub/../r.x"], "--output and --html both write to"),
    (["study", "cold-start", "--csv", "r.x", "--html", "r.x"], "--html and --csv both write to 'r.x'"),
    (["export", "b", "--csv", "r.x", "--parquet", "r.x"], "--csv and --parquet both write to 'r.x'"),
    (["fmu", "r.fmu", "--json", "r.fmu"], "FILE and --json both write to 'r.fmu'"),
])
def test_one_path_for_two_outputs_is_refused(argv, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as left:
        main(argv)
    err = capsys.readouterr().err
    assert left.value.code == 2 and said in err and len(err.splitlines()) == 1


@pytest.mark.parametrize("argv, said", [
    (["simulate", "d", "-o", "b", "--json", "b/b.mcap"], "/b/b.mcap' into what --output writes as a whole"),
    (["import", "l.csv", "--mapping", "m", "--json", "b/metadata.yaml", "-o", "b"], "/b/metadata.yaml' into what --output writes"),
    (["export", "b", "--mcap", "m", "--json", "m/m.mcap"], "--json would write "),
    (["export", "b", "--mcap", "m", "--csv", "m/m_0.mcap"], "--csv would write "),
    (["export", "b", "--telemetry", "t", "--csv", "t/drive_telemetry.csv"], "/t/drive_telemetry.csv' into what --telemetry writes"),
    (["export", "b", "--telemetry", "t", "--json", "./t/sub/mapping.yaml"], "/t/sub/mapping.yaml' into what --telemetry writes"),
    (["export", "b", "--telemetry", "m/t", "--mcap", "m"], "/m/t' into what --mcap writes"),
    (["up", "--record", "b", "--log", "b/log"], "/b/log' into what --record writes"),
    (["replay", "b", "--html", "r", "--json", "r/x"], "/r/x' into what --html writes"),
])
def test_an_output_in_another_one_is_refused(argv, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as left:
        main(argv)
    err = capsys.readouterr().err
    assert left.value.code == 2 and said in err and len(err.splitlines()) == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize("argv", [
    ["demo", "--out"], ["layouts"], ["fleet", "FOLDER", "--out"], ["real", "--data", "FOLDER", "--out"], ["gap-bench"],
], ids=lambda argv: argv[0])  # fmt: skip
def test_a_folder_for_results_is_looked_at_before_the_work(argv, tmp_path, capsys, repo_root, monkeypatch):
    monkeypatch.chdir(repo_root)
    (tmp_path / "emps").mkdir()
    (tmp_path / "file").touch()
    (tmp_path / "emps" / "metadata.yaml").touch()
    argv = [str(tmp_path) if word == "FOLDER" else word for word in argv]
    for folder, said in ((tmp_path / "file", f"{tmp_path}/file is no folder"), (tmp_path / "file" / "new", f"{tmp_path}/file is no folder"),
                         (Path("/proc/new"), "cannot be written: /proc: "), (tmp_path / "emps", "is a recording, nothing is written")):
        if argv[0] == "real" and folder.name == "emps":
            continue  # its recordings are no bags
        assert main([*argv, str(folder)]) == 2
        err = capsys.readouterr().err
        assert said in err and len(err.splitlines()) == 1, err


@pytest.mark.parametrize("argv", [
    ["demo", "--out", ""], ["layouts", ""], ["real", "--data", ""], ["info", ""], ["calibrate", ""], ["motor", "--description", " "],
    ["gap", "b", "--validation", ""],
], ids=lambda argv: argv[0])  # fmt: skip
def test_an_empty_name_is_no_folder(argv, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as left:
        main(argv)
    assert left.value.code == 2 and "an empty name of a file or folder" in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_the_page_is_not_served_by_a_rig_file_that_cannot_be_used(tmp_path, capsys):
    (tmp_path / "own.yaml").touch()
    assert main(["view", "--rig", str(tmp_path / "own.yaml"), "--log", str(tmp_path / "log")]) == 2
    assert f"error: {tmp_path / 'own.yaml'}: is empty" in capsys.readouterr().err and not (tmp_path / "log").exists()


def test_a_demo_overwrites_neither_its_input_nor_its_own_numbers(tmp_path, capsys, repo_root, monkeypatch):
    monkeypatch.chdir(repo_root)
    (tmp_path / "twin").mkdir()
    (tmp_path / "twin" / "twin_0.mcap").touch()
    (tmp_path / "twin" / "recorded_by_demo").touch()
    for more, said in ((["--bag", tmp_path / "twin"], "twin would be overwritten by what is recorded"),
                       (["--json", tmp_path / "report.json"], "--json and --out both write to"),
                       (["--json", "bags/paper_cycle/metadata.yaml"], "--json would overwrite 'bags/paper_cycle/metadata.yaml'")):
        assert main(["demo", "--out", str(tmp_path), *map(str, more)]) == 2
        assert said in capsys.readouterr().err and (tmp_path / "twin" / "twin_0.mcap").exists()


def test_a_demo_removes_what_a_demo_recorded_and_nothing_else(tmp_path, monkeypatch, repo_root):
    monkeypatch.chdir(repo_root)
    played = []

    def play(bag, recorded, *_, **__):
        assert not recorded.exists()
        recorded.mkdir(parents=True)
        (recorded / "twin_0.mcap").write_text(f"{len(played)}")
        played.append(recorded)
        raise InputError("a node ended")

    monkeypatch.setattr("ddh_twin_py.cli.live_play.play", play)
    monkeypatch.setattr("ddh_twin_py.estimation.replay.replay", lambda *_, **__: None)
    monkeypatch.setattr("ddh_twin_py.cli.replay.leave_one_out", lambda *_: {})
    (tmp_path / "twin").mkdir()
    (tmp_path / "twin" / "twin_0.mcap").write_text("of a machine")  # as ddh-twin up --record leaves it
    for _ in range(2):
        assert main(["demo", "--bag", "bags/paper_cycle", "--out", str(tmp_path), "--quiet"]) == 2
    assert played == [tmp_path / "twin_2", tmp_path / "twin_2"]
    assert (tmp_path / "twin" / "twin_0.mcap").read_text() == "of a machine" and (tmp_path / "twin_2" / "twin_0.mcap").read_text() == "1"


@pytest.mark.parametrize("written", ["metadata.yaml", "rig.yaml", "b_1.mcap"])
def test_one_file_of_a_bag_stands_for_the_bag(written, tmp_path, capsys):
    for name in ("metadata.yaml", "rig.yaml", "b_0.mcap", "b_1.mcap", "page.html"):
        (tmp_path / name).touch()
    with pytest.raises(SystemExit) as left:
        main(["info", str(tmp_path / "b_0.mcap"), "--json", str(tmp_path / written)])
    assert left.value.code == 2 and "--json would overwrite" in capsys.readouterr().err
    assert not reads(str(tmp_path / "b_0.mcap"), str(tmp_path / "page.html"))
    (tmp_path / "metadata.yaml").unlink()
    assert not reads(str(tmp_path / "b_0.mcap"), str(tmp_path / "b_1.mcap"))  # two recordings side by side, of which one is made anew


@pytest.mark.parametrize("argv", [
    ["fleet", "bags", "--out", "{}", "--html", "{}/fleet.csv"],
    ["fleet", "bags", "--out", "{}", "--json", "{}/results/x.json"], ["fleet", "bags", "--out", "{}", "--csv", "{}/results/x.json"],
    ["demo", "--out", "{}", "--json", "{}/twin/metadata.yaml"], ["layouts", "{}", "--json", "{}/foxglove.json"],
    ["gap-bench", "score", "{}", "--html", "{}/scores.json"], ["gap-bench", "score", "{}", "--json", "{}/scores.html"],
], ids=lambda argv: argv[0])  # fmt: skip
def test_what_a_verb_writes_by_itself_is_not_written_twice(argv, tmp_path, capsys, repo_root, monkeypatch):
    monkeypatch.chdir(repo_root)
    assert main([word.format(tmp_path) for word in argv]) == 2
    said = capsys.readouterr().err
    assert f"both write to '{tmp_path}" in said and len(said.splitlines()) == 1 and not list(tmp_path.iterdir())


def test_the_nearest_of_a_file_that_is_not_there(tmp_path, capsys):
    (tmp_path / "press_7.yaml").write_text("")
    assert did_you_mean(tmp_path / "pres_7.yaml") == f"; the nearest is {tmp_path / 'press_7.yaml'}"
    assert did_you_mean(tmp_path / "crane.yaml") == "" and did_you_mean(tmp_path / "no" / "x.yaml") == ""
    assert main(["info", str(tmp_path / "press_8.yaml")]) == 2
    assert f"does not exist; the nearest is {tmp_path / 'press_7.yaml'}" in capsys.readouterr().err


@pytest.mark.parametrize("argv", [
    ["view", "{}/press_7_bga"], ["up", "--source", "bag", "--bag", "{}/press_7_bga"], ["fleet", "{}/press_7_bga"],
    ["gap", "bags/paper_cycle", "--commissioning", "{}/press_7_bga"], ["real", "--data", "{}/press_7_bga"], ["replay", "{}/press_7_bga"],
], ids=lambda argv: argv[0])  # fmt: skip
def test_every_verb_names_the_nearest_input(argv, tmp_path, capsys, repo_root, monkeypatch):
    monkeypatch.chdir(repo_root)
    (tmp_path / "press_7_bag").mkdir()
    assert main([word.format(tmp_path) for word in argv]) == 2
    assert f"; the nearest is {tmp_path / 'press_7_bag'}" in capsys.readouterr().err


def on_a_terminal(argv, **environment) -> str:
    """What a command writes where standard output is a terminal."""
    leader, follower = pty.openpty()
    env = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "FORCE_COLOR")}
    process = subprocess.Popen([sys.executable, "-m", "ddh_twin_py.cli.main", *argv], stdout=follower, stderr=subprocess.DEVNULL,
                               stdin=subprocess.DEVNULL, env={**env, "TERM": "xterm-256color", **environment})
    os.close(follower)
    written = b""
    while True:
        try:
            part = os.read(leader, 65536)
        except OSError:
            break
        if not part:
            break
        written += part
    os.close(leader)
    process.wait()
    return written.decode()


COLOUR = re.compile(r"\x1b\[[0-9;]*3[0-7]m")


def test_colours_on_a_terminal_alone_and_never_with_no_color():
    argv = ["doctor", "--no-graph"]
    assert COLOUR.search(on_a_terminal(argv))
    assert not COLOUR.search(on_a_terminal(argv, NO_COLOR="1"))
    piped = subprocess.run([sys.executable, "-m", "ddh_twin_py.cli.main", *argv], capture_output=True, text=True)
    assert "installation" in piped.stdout and "\x1b" not in piped.stdout + piped.stderr


def complete(script, *words) -> list[str]:
    """What bash offers for the last word."""
    line = " ".join(f"'{word}'" for word in ("ddh-twin", *words))
    code = f"source {script}; COMP_WORDS=({line}); COMP_CWORD={len(words)}; _shtab_ddh_twin; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    return subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True).stdout.split()


def test_completion(tmp_path, capsys, monkeypatch):
    assert main(["completion", "bash"]) == 0
    script = tmp_path / "completion.bash"
    script.write_text(capsys.readouterr().out)
    assert complete(script, "rep") == ["replay"]
    assert set(complete(script, "gap")) == {"gap", "gap-design", "gap-bench"}
    assert complete(script, "replay", "--leave") == ["--leave-one-out"]
    assert complete(script, "up", "--source", "sim") == ["simulation"]
    assert complete(script, "gap", "--without", "pump_1.l") == ["pump_1.leakage"]
    assert complete(script, "gap-design", "--sensors", "motor_w") == ["motor_winding"]
    assert complete(script, "gap-design", "mixed", "--sensors", "tank_oil,motor_w") == ["tank_oil,motor_winding"]
    assert complete(script, "study", "cold-start", "--duty", "mixed,paper_cycle_f") == ["mixed,paper_cycle_fast"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bag_of_mine").mkdir()
    assert "bag_of_mine" in complete(script, "info", "bag_")
    (tmp_path / "mine.yaml").touch()
    for words in (("gap-design",), ("simulate",), ("gap-design", "mixed", "--commissioning"), ("up", "--duty"), ("verify", "--duty")):
        assert set(complete(script, *words, "mi")) == {"mixed", "mine.yaml"}, words
    assert main(["completion", "zsh"]) == 0
    zsh = capsys.readouterr().out
    assert zsh.startswith("#compdef ddh-twin") and "--leave-one-out" in zsh
    assert main(["completion", "fish"]) == 0
    fish = capsys.readouterr().out
    assert "complete -c ddh-twin" in fish and "leave-one-out" in fish
    with pytest.raises(SystemExit):
        main(["completion", "fsih"])
    assert "no shell 'fsih'; the nearest is 'fish', valid are bash, zsh, fish" in capsys.readouterr().err


def test_pages_are_up_to_date(repo_root):
    for name, text in (("command_line.md", command_line_page(build_parser())), ("messages.md", message_page(repo_root / "ddh_msgs")),
                       ("rig_sheet.md", rig_sheet_page())):
        assert (repo_root / "docs" / name).read_text() == text, "run scripts/reference_pages.py"


def test_every_message_and_verb_has_its_place(repo_root):
    page = (repo_root / "docs/messages.md").read_text()
    definitions = [path for folder in ("msg", "srv", "action") for path in (repo_root / "ddh_msgs" / folder).iterdir()]
    assert len(definitions) > 15 and all(f"\n### {path.stem}\n" in page for path in definitions)
    line = (repo_root / "docs/command_line.md").read_text()
    assert all(f"\n## {verb}\n" in line for verb in VERBS) and set(NO) <= set(VERBS)
    assert all(f"| {code} | " in line for code in EXIT_CODES)
