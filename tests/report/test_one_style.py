"""Every report: one look, an end that says what the numbers rest on, a machine-readable twin with the same end, small for an hour."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.cli.main import main
from ddh_twin_py.report.gap.page import gap_document, gap_end
from ddh_twin_py.report.page.charts import Chart, Trace
from ddh_twin_py.report.replay.agreement import compare
from ddh_twin_py.report.replay.page import replay_document
from support.made_diagnosis import made_diagnosis

LARGEST = 8_000_000  # bytes, for an hour of data
REPORTS = {
    "replay": ["replay", "BAG"],
    "calibration": ["calibrate", "BAG", "--only", "motor.torque_constant"],
    "consistency": ["verify", "--seeds", "2", "--duration", "60"],
    "cold_start": ["study", "cold-start", "--ambient", "20", "--grades", "32", "--duty", "paper_cycle", "--hours", "0.05"],
    "motor": ["motor", "--layers", "2"],
    "design": ["gap-design", "paper_cycle", "--duration", "60", "--sensors", "none", "--without-commissioning"],
    "paper": ["paper"],
}


@pytest.fixture(scope="module")
def short_bag(paper_cycle_bag, tmp_path_factory):
    from ddh_twin_py.bags.reader import read_recording
    from ddh_twin_py.bags.writer import write_recording

    return write_recording(tmp_path_factory.mktemp("style") / "short", read_recording(paper_cycle_bag).between(0.0, 40.0))


def end_of(page: str) -> dict[str, str]:
    """What the last section says: name to text."""
    last = page[page.rindex('<dl class="about">'):]
    assert "<h2>About these numbers</h2>" in page and "<section" not in last
    return {name: re.sub(r"<[^>]+>", " ", value) for name, value in re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>(?=<dt>|</dl>)", last)}


def style_of(page: str) -> str:
    """The project's own style sheet."""
    return page[page.index("<style>"):page.index("</style>")][-2000:]


def look(page: str) -> None:
    assert page.startswith('<!doctype html>\n<html lang="en"') and "default-src 'none'" in page
    for part in ('<p class="kind">', "<h1>", '<p class="verdict ', "@media print", "break-inside: avoid"):
        assert part in page, part
    end = end_of(page)
    assert {"Data split", "Rig file", "Versions", "Assumptions"} <= end.keys()
    assert all(end[name].strip() for name in ("Data split", "Rig file", "Versions", "Assumptions")), end
    assert "ddh_twin_py" in end["Versions"] and "numpy" in end["Versions"]


@pytest.mark.parametrize("kind", REPORTS)
def test_page_and_its_twin(kind, short_bag, tmp_path):
    argv = [str(short_bag) if word == "BAG" else word for word in REPORTS[kind]]
    page, numbers = tmp_path / "r.html", tmp_path / "r.json"
    assert main([*argv, "--html", str(page), "--json", str(numbers), "--quiet"]) in (0, 1)
    markup, end = page.read_text(), json.loads(numbers.read_text())["end_matter"]
    look(markup)
    written = end_of(markup)
    assert end["rig_file"] == written["Rig file"].strip()
    assert all(f"{name} {number}" in written["Versions"] for name, number in end["versions"].items())
    assert end["data_split"] and len(end["assumptions"]) == markup[markup.rindex('<dl class="about">'):].count("<li>")


def test_the_gap_report_too():
    diagnosis = made_diagnosis()
    markup = gap_document(diagnosis).html()
    look(markup)
    assert end_of(markup)["Data split"].strip() == gap_end(diagnosis).as_json()["data_split"]


def test_all_look_the_same(result):
    assert style_of(gap_document(made_diagnosis()).html()) == style_of(replay_document(result, compare(result)).html())


def an_hour(result):
    """The made result, repeated for an hour of intervals, with a spike that is one interval wide in every signal."""
    times = -(-72_000 // result.time.size)

    def long(values):
        return np.concatenate([values] * times)

    n = result.time.size * times
    rng = np.random.default_rng(1)
    measured, soft, free = (long(values) for values in (result.measured, result.soft, result.free))
    for values in (measured, soft, free):
        for name in values.dtype.names:
            values[name] += rng.normal(0.0, 1.0, values[name].shape)  # what cannot be packed
    measured["pressure_rod_side"][40_000] = 5.0e6
    sensors = {}
    for name, found in result.sensors.items():
        when = 0.5 * np.arange(n // 10)
        wave = 300.0 + rng.normal(0.0, 1.0, when.size)
        sensors[name] = replace(found, time=when, measured=wave, predicted=wave, fused=wave, fused_std=np.full(when.size, 0.2),
                                row=np.searchsorted(0.05 * np.arange(1, n + 1), when))
    return replace(result, time=0.05 * np.arange(1, n + 1), measured=measured, soft=soft, free=free, sensors=sensors,
                   free_temperature=long(result.free_temperature), fused=long(result.fused), fused_std=long(result.fused_std))


def test_an_hour_is_small_and_keeps_its_peaks(result):
    hour = an_hour(result)
    markup = replay_document(hour, compare(hour)).html()
    assert len(markup.encode()) < LARGEST
    (spec,) = (spec for text in re.findall(r'<script type="application/json">(.*?)</script>', markup)
               if (spec := json.loads(text))["title"] == "Pressure rod side")
    assert spec["y"][0][1] == pytest.approx(50.0)  # bar, the highest value of the line that was measured


def test_a_chart_of_any_length_has_few_points():
    rng = np.random.default_rng(1)
    sizes = [len(Chart("t", "", np.arange(float(n)), [Trace("x", "measured", rng.normal(size=n))]).html((0.0, float(n))))
             for n in (24_000, 1_000_000)]
    assert sizes[1] < 2.0 * sizes[0]
