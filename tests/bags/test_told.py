"""What a bag says of itself is shown on one line, escaped and of bounded length, and costs no time."""

from dataclasses import replace

from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.storage import told
from ddh_twin_py.bags.writer import BagWriter, write_recording
from ddh_twin_py.cli.main import main
from support.bag_rows import write_rows

ESCAPE = "\x1b[31mpress\x07\n7"


def test_what_can_be_shown_stays_as_it_is():
    assert told("press 7 äöü µ") == "press 7 äöü µ" and told("x" * 255) == "x" * 255
    assert told(ESCAPE) == "\\x1b[31mpress\\x07\\n7"
    assert told("\x1b" * 100_000).startswith("\\x1b\\x1b") and len(told("\x1b" * 100_000)) < 300


def test_a_rig_id_is_escaped_and_bounded(tmp_path, short, capsys):
    path = write_recording(tmp_path / "bag", replace(short, rig=replace(short.rig, rig_id=ESCAPE + "x" * 100_000, oil_grade=ESCAPE)))
    rig = read_recording(path).rig
    assert rig.rig_id.startswith("\\x1b[31mpress\\x07\\n7xxx") and rig.rig_id.endswith("x... (100013 characters)") and len(rig.rig_id) < 300
    assert main(["info", str(path)]) == 0
    out = capsys.readouterr().out
    assert "\x1b" not in out and "\x07" not in out and "press" in out and len(out) < 5000


def test_an_oil_is_escaped_once(tmp_path, short):
    read = read_recording(write_recording(tmp_path / "bag", replace(short, rig=replace(short.rig, oil_grade="VG\n32"))))
    (finding,) = read.findings
    assert "oil_grade is 'VG\\n32', the reference" in finding.message
    (finding,) = replace(read, findings=[]).held_against("ISO VG 46").findings
    assert "oil_grade is 'VG\\n32', the rig file's is 'ISO VG 46'" in finding.message
    (finding,) = replace(read, findings=[], rig=replace(read.rig, oil_grade="VG\n32")).held_against("ISO VG 46").findings
    assert "oil_grade is 'VG\\n32', the rig" in finding.message


def test_so_is_a_topic(tmp_path, short, capsys):
    with BagWriter(tmp_path / "bag") as writer:
        writer.write_rig(short.rig, short.epoch_ns, "/" + ESCAPE)
        for name in ("drive/telemetry", "hydraulics/telemetry"):
            stream = dict(short.streams())[name]
            write_rows(writer, f"/{ESCAPE}/{name}", f"ddh_msgs/msg/{'Drive' if name[0] == 'd' else 'Hydraulic'}Telemetry",
                       stream.stamps(short.epoch_ns), stream.values)
    assert main(["info", str(tmp_path / "bag")]) == 0
    out, err = capsys.readouterr()
    assert "\x1b" not in out + err and "\\x1b[31mpress" in out
