"""The page of a gap diagnosis: every verdict, what it must hold, and what it must not."""

import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import jsonschema
import numpy as np
import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.report.document import json_text
from ddh_twin_py.report.gap_report import gap_document
from ddh_twin_py.report.units import plus_minus
from support.made_diagnosis import KINDS, made_diagnosis


class Page(HTMLParser):
    """Headings, attributes, text and unclosed tags of a page."""

    def __init__(self, markup):
        super().__init__()
        self.headings, self.attributes, self.words, self.open, self.charts, self.figures = [], [], [], [], [], 0
        self.feed(markup)

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, *pair) for pair in attrs]
        self.figures += tag == "svg"
        if tag not in ("meta", "path", "rect", "circle"):
            self.open.append(tag)

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            if data.startswith("{"):
                self.charts.append(json.loads(data))
        elif self.open and self.open[-1] != "style":
            self.words.append(data)
            if self.open[-1] == "h2":
                self.headings.append(data)

    def handle_endtag(self, tag):
        if tag not in ("meta", "path", "rect", "circle"):
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def diagnoses():
    return {kind: made_diagnosis(kind, seconds=300.0) for kind in KINDS}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_made_up_follows_the_contract(kind, diagnoses, shared_dir):
    schema = json.loads((shared_dir / "gap_report.schema.json").read_text())
    jsonschema.validate(json.loads(json_text(diagnoses[kind].report)), schema)


@pytest.mark.parametrize("kind", KINDS)
def test_every_verdict_makes_a_whole_page(kind, diagnoses):
    diagnosis = diagnoses[kind]
    markup = gap_document(diagnosis).html()
    page = Page(markup)
    assert not page.open
    assert page.headings[:2] == ["In short", "Where"] and page.headings[-1] == "About these numbers"
    said = " ".join(page.words)
    assert diagnosis.sentence in said
    assert diagnosis.report["held_out"] in said and all(note in said for note in diagnosis.report["notes"])
    assert all(a in said for a in diagnosis.assumptions)
    assert "<1>" not in markup and "&lt;1&gt;" in markup and "<sheet>" not in markup
    for tag, name, value in page.attributes:
        assert name not in ("src", "href", "srcset", "action"), (tag, name, value)
    assert ("What no listed effect explains" in page.headings) == (kind == "unknown")
    assert ("What cannot be told apart" in page.headings) == (kind == "ambiguous")
    assert ("Measured less twin, before and after" in page.headings) == (kind != "insufficient")
    assert len(page.charts) == len(diagnosis.traces)
    assert "nan" not in re.sub(r"<script.*?</script>", "", markup, flags=re.DOTALL).lower()


def test_every_hypothesis_place_and_signal_is_there_with_its_figures(diagnoses):
    for kind, diagnosis in diagnoses.items():
        said = " ".join(Page(gap_document(diagnosis).html()).words)
        for lack in (*diagnosis.lacking, *diagnosis.alone):
            assert plus_minus(lack.value, lack.std, lack.unit, sign=True) in said, (kind, lack)
        for weighed in diagnosis.weighed:
            for effect, (value, std, unit, _) in weighed.values.items():
                assert plus_minus(value, std, unit) in said, (kind, effect)
        for row in diagnosis.report["why"]:
            if row["effect"] in EFFECTS and row["probability"] > 0.4:
                known = EFFECTS[row["effect"]]
                assert all(words in said for words in (known.about, known.law, known.signature, known.check))
        for name, row in diagnosis.report["shrink"].items():
            assert f"{row['before'] / row['noise']:.2f}" in said and f"{row['after'] / row['noise']:.2f}" in said, name
        for parameter in diagnosis.parameters:
            assert parameter.name in said and f"{parameter.value:.4g}" in said
            if parameter.name in diagnosis.rig.quantities:
                assert diagnosis.rig.quantities[parameter.name].source in said


def test_reasons_and_the_next_test_are_there(diagnoses):
    said = " ".join(Page(gap_document(diagnoses["ambiguous"]).html()).words)
    assert all(reason in said for reason in diagnoses["ambiguous"].confusable.values())
    assert "Run the uncoupled motor at 1000 rpm for ten minutes." in said and "7.5" in said and "about 1 808 times" in said
    assert "pump 1: friction from motor: bearing friction" in said


def test_charts_hold_what_was_measured_less_what_the_twin_says(diagnoses):
    diagnosis = diagnoses["explained"]
    chart = Page(gap_document(diagnosis).html()).charts[0]  # furthest off: the piston side's pressure
    trace = diagnosis.traces["pressure_piston_side"]
    assert chart["unit"] == "bar" and [line["label"] for line in chart["lines"]] == ["measured", "before", "after"]
    assert chart["differences"] == [[0, 1], [0, 2]] and chart["floor"] == pytest.approx(trace.floor * 1e-5)
    low, high, _ = chart["y"][0]
    assert (low, high) == (trace.measured.min() * 1e-5, trace.measured.max() * 1e-5)


def test_temperatures_are_in_degC_and_their_differences_in_kelvin(diagnoses):
    page = gap_document(diagnoses["explained"]).html()
    (chart,) = (c for c in Page(page).charts if c["unit"] == "°C" and c["floor"] == 0.2)
    assert chart["y"][0][1] < 40.0
    assert "missing, K against oil temperature, °C" in page and "oil temperature 22.9 to 29.9 °C" in page


def test_an_hour_stays_below_eight_megabytes():
    diagnosis = made_diagnosis("explained", seconds=3600.0)
    traces = {f"{n}_{i}": t for i in range(2) for n, t in diagnosis.traces.items()}
    page = gap_document(replace(diagnosis, traces=traces)).html()
    assert len(Page(page).charts) == 2 * len(diagnosis.traces)
    assert len(page.encode()) < 8e6


def test_a_missing_sample_and_a_signal_without_any_do_not_break_the_page(diagnoses):
    diagnosis = diagnoses["explained"]
    speed = diagnosis.traces["speed"]
    holes = replace(speed, measured=np.where(np.arange(speed.time.size) % 3 == 0, np.nan, speed.measured))
    none = replace(speed, **{n: np.zeros(0) for n in ("time", "measured", "before", "after")})
    page = Page(gap_document(replace(diagnosis, traces={"speed": holes, "current": none})).html())
    assert len(page.charts) == 1 and not page.open
