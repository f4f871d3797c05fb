"""The page: one file that asks for nothing, holds the data of its charts, and escapes what it shows."""

import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.report.page.charts import Chart, Trace, quantised
from ddh_twin_py.report.page.document import Column, Document, EndMatter, table
from ddh_twin_py.report.replay.agreement import compare
from ddh_twin_py.report.replay.page import findings_table, replay_document, replay_json
from ddh_twin_py.telemetry.recording import Finding, temperature_stream


class Page(HTMLParser):
    """Tags, attributes and chart data of a page."""

    def __init__(self, markup: str) -> None:
        super().__init__()
        self.attributes, self.specs, self.tables, self.open = [], [], 0, []
        self.headings: list[str] = []
        self.feed(markup)

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, *pair) for pair in attrs]
        self.open.append((tag, dict(attrs)))
        self.tables += tag == "table"

    def handle_data(self, data):
        if self.open and self.open[-1] == ("script", {"type": "application/json"}):
            self.specs.append(json.loads(data))
        if self.open and self.open[-1][0] == "h2":
            self.headings.append(data)

    def handle_endtag(self, tag):
        while self.open and self.open.pop()[0] != tag:
            pass


def unpacked(packed: list) -> np.ndarray:
    low, high, text = packed
    place = np.frombuffer(base64.b64decode(text), "<u2").astype(float)
    return np.where(place == 65535, np.nan, low + place * (high - low) / 65534)


@pytest.fixture
def markup(result) -> str:
    return replay_document(result, compare(result)).html()


def test_the_page_asks_for_nothing(markup):
    page = Page(markup)
    for tag, name, value in page.attributes:
        assert name not in ("src", "href", "srcset", "data", "action", "poster"), (tag, name, value)
    assert not {tag for tag, *_ in page.attributes} & {"link", "img", "iframe", "object", "embed", "base"}
    assert "@import" not in markup and "url(" not in markup
    assert not re.search(r"\b(fetch|XMLHttpRequest|WebSocket|importScripts|sendBeacon)\b", markup)
    assert "default-src 'none'" in markup


def test_names_from_outside_are_escaped(result, markup):
    assert "odd </script>" not in markup
    assert "odd &lt;/script&gt; &amp; name" in markup
    assert "&lt;first at 1 s&gt;" in markup
    hostile = Chart("t", "°C", np.arange(3.0), [Trace("</script><b>", "measured", np.zeros(3))])
    assert "</script><b>" not in hostile.html((0.0, 2.0))
    with pytest.raises(ValueError, match="valid are measured"):
        Chart("t", "", np.arange(3.0), [Trace("x", "mesured", np.zeros(3))]).html((0.0, 2.0))


def test_charts_hold_what_was_measured(result, markup):
    specs = {spec["title"]: spec for spec in Page(markup).specs}
    assert len(specs) == 2 + 9 + 1
    chart = specs["Pressure rod side"]
    assert chart["unit"] == "bar" and [line["label"] for line in chart["lines"]] == ["measured", "free run"]
    values = unpacked(chart["y"][0])
    expected = result.measured["pressure_rod_side"] * 1e-5
    np.testing.assert_allclose(values, expected, atol=np.ptp(expected) / 65534)
    assert values.max() == expected.max() and values.min() == expected.min()
    assert {tuple(spec["domain"]) for spec in specs.values()} == {(0.05, 20.0)}


def test_what_is_just_beyond_the_floor_is_not_rounded_to_it(result):
    for comparison in result.sensors.values():
        comparison.predicted[:] = comparison.measured + 1.604 * comparison.noise
    agreement = compare(result)
    page = replay_document(result, agreement).html()
    assert "<dt>Furthest off</dt><dd>1.604 × noise<" in page and "1.604 times noise" in agreement.verdict


def test_the_warmest_place_stands_beside_what_its_sensor_would_read(result):
    result.fused[:, NODES.index("end_winding")] = 273.15 + 50.08
    page = replay_document(result, compare(result)).html()
    assert "<dd>50.1 °C<" in page and "end winding itself, ± 0.30 K; its sensor, which lags, would read 28.8" in page
    assert "This table, and both lines of a chart, are seen through the sensor" in page


def test_packing_keeps_extremes_and_gaps():
    values = np.array([1.5, np.nan, -7.25, 3.0])
    back = unpacked(quantised(values))
    assert np.isnan(back[1]) and back[2] == -7.25 and back[3] == 3.0
    assert np.isnan(unpacked(quantised(np.full(2, np.nan)))).all()
    np.testing.assert_array_equal(unpacked(quantised(np.full(3, 4.0))), np.full(3, 4.0))


def test_an_hour_stays_small():
    n = 72_000
    rng = np.random.default_rng(1)
    time = 0.05 * np.arange(n)
    traces = [Trace(name, "measured", rng.normal(size=n)) for name in "abc"]
    chart = Chart("t", "W", time, traces, differences=((1, 0), (2, 0)))
    assert len(chart.html((0.0, 3600.0))) < 400_000  # a replay has 19 of them, most smaller


def test_the_end_matter_is_there(result, markup):
    page = Page(markup)
    assert page.headings[-1] == "About these numbers" and page.tables == 4
    for words in ("Data split", "Nothing was fitted", "ddh_rig.yaml", "Versions", "numba", "Assumptions", "50 ms"):
        assert words in markup


def test_json_twin(result):
    agreement = compare(result)
    data = json.loads(json.dumps(replay_json(result, agreement)))
    assert data["verdict"] == agreement.verdict
    assert data["recording"]["rig"]["payload_mass"] == 149.5
    assert data["end_matter"]["data_split"] and data["end_matter"]["assumptions"]
    assert {row["sensor"] for row in data["temperatures"]} == {"tank_oil", "motor_winding"}


def test_json_has_no_nan(result, tmp_path):
    from ddh_twin_py.report.page.document import write_json

    path = write_json(tmp_path / "deep" / "report.json", replay_json(result, compare(result)))
    data = json.loads(path.read_text(), parse_constant=pytest.fail)
    assert data["findings"][0]["value"] is None


def test_a_row_that_does_not_fit_is_an_error():
    with pytest.raises(ValueError):
        table([Column("a"), Column("b")], [("1",)])


def test_a_page_without_charts_carries_no_script_library():
    page = Document("Gap", "t", "v.", EndMatter("none", "rig", ()))
    assert "uPlot" not in page.html().replace("uPlot.", "")[:2000] and len(page.html()) < 40_000


def test_charts_go_on_where_the_clock_jumps_back(result):
    from dataclasses import replace

    result.time[200:] -= 8.0
    page = Page(replay_document(result, compare(result)).html())
    spec = next(spec for spec in page.specs if spec["title"] == "Speed")
    x = np.frombuffer(base64.b64decode(spec["x"]), "<f4")
    assert (np.diff(x) > 0).all() and x[-1] == pytest.approx(20.0)
    assert compare(replace(result)).duration == pytest.approx(20.0)


def test_findings_that_strike_few_samples_are_folded_away(result):
    when = 0.5 * np.arange(1000)
    topic = "/ddh/temperature/tank_oil"
    rare, often = (Finding("warning", "bags/x", topic, "temperature", float("nan"), count, f"{count} are NaN", mended=True)
                   for count in (7, 700))
    wrong = Finding("error", "bags/x", topic, "temperature", 300.0, 2, "2 samples in kelvin")
    recording = replace(result.recording, namespace="/ddh", temperatures={"tank_oil": temperature_stream(when, np.full(1000, 300.0))})
    open_part, _, folded = str(findings_table(replace(recording, findings=[rare, often, wrong]))).partition("<details>")
    assert "700 are NaN" in open_part and "kelvin" in open_part and open_part.index("kelvin") < open_part.index("700")
    assert "7 are NaN" in folded and "1 slight warning: it strikes at most 1 % of a topic" in folded
    assert "<details>" not in findings_table(replace(recording, findings=[often]))
    assert str(findings_table(replace(recording, findings=[rare]))).startswith("<details>")
