"""The terminal's numbers are the JSON's numbers."""

import io

from ddh_twin_py.report.replay.agreement import compare
from ddh_twin_py.report.replay.page import replay_json
from ddh_twin_py.report.replay.summary import print_summary
from rich.console import Console


def rendered(agreement, width=80) -> list[str]:
    out = io.StringIO()
    print_summary(agreement, "paper_cycle", Console(file=out, width=width))
    return out.getvalue().splitlines()


def test_numbers_equal_the_json(result):
    agreement = compare(result)
    data = replay_json(result, agreement)
    lines = rendered(agreement)
    for row in data["temperatures"]:
        line = next(x for x in lines if x.startswith(row["sensor"].replace("_", " ")))
        for key in ("measured_final_degC", "predicted_final_degC", "fused_final_degC", "fused_final_std_K",
                    "rms_predicted_K", "rms_fused_K"):
            assert f"{row[key]:.2f}" in line.split(), (key, line)
    for row in data["signals"]:
        line = next(x for x in lines if x.startswith(row["name"].replace("_", " ")))
        assert f"{row['free_in_noise']:.2f}" in line.split()
        assert ("input" in line.split()) == (row["rms_soft"] is None)
    assert data["verdict"] == " ".join(" ".join(lines[1:6]).split())[: len(data["verdict"])]


def test_fits_a_terminal(result):
    for agreement in (compare(result), compare(result, left_out=result.sensors)):
        lines = rendered(agreement)
        assert len(lines) <= 40 and max(map(len, lines)) <= 80
        assert not any("…" in line for line in lines)  # nothing had to be cut off
    assert not any("\x1b" in line for line in lines)
