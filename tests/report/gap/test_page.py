"""The page of a gap diagnosis: every verdict, what it must hold, and what it must not."""

import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import jsonschema
import numpy as np
import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.diagnosis import Weighed
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.verdict.unknown import UNLISTED
from ddh_twin_py.gap.words import BesideReport, sentence
from ddh_twin_py.report.gap.checks import CHECKS, checks_of
from ddh_twin_py.report.gap.hypotheses import hypotheses
from ddh_twin_py.report.gap.page import gap_document
from ddh_twin_py.report.gap.rest import unknown as unknown_part
from ddh_twin_py.report.gap.summary import gap_summary
from ddh_twin_py.report.page.document import json_text
from ddh_twin_py.report.units import in_file, plus_minus
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


def test_no_gap_says_how_large_each_effect_would_have_to_be(diagnoses):
    table = gap_document(diagnoses["no_gap"]).html().partition("What would have shown")[2].partition("</table>")[0]
    rows = re.findall(r'<th scope="row">(.*?)</th>', table)
    assert rows == ["load: mass", "pump 1: friction", "motor: cooling", "tank: cooling"]  # what shows least last
    assert "mass 147.5 kg (−2.00 kg)" in table and "torque +0.250 N·m<" in table
    assert "convection ratio 29.3 (+28.3), which no machine reaches" in table and '<td class="n">1.9</td>' in table
    assert all("What would have shown" not in gap_document(diagnoses[kind]).html() for kind in KINDS if kind != "no_gap")


def test_what_cannot_be_told_of_since_when_stands_on_the_card_and_first_among_what_would_have_shown(diagnoses):
    untold = {"relief_valve.setting": "the field recordings show 155 bar", "tank.oil_level": "as well"}
    markup = gap_document(replace(diagnoses["no_gap"], untold=untold)).html()
    verdict = re.search(r"<dt>Verdict</dt><dd>(.*?)</dd>", markup)[1]
    assert verdict.endswith("<small>but relief valve: opening pressure and 1 more may have changed since commissioning; this cannot be "
                            "told here</small>")
    shown = markup.partition("<h2>What would have shown")[2]
    first, second = re.findall(r'<th scope="row">(.*?)</th><td>(.*?)</td>', shown)[:2]
    assert first == ("relief valve: opening pressure", "cannot be told here: the field recordings show 155 bar")
    assert second[0] == "tank: oil level"
    assert "Of these it says nothing, at no size: relief valve: opening pressure, tank: oil level;" in shown
    alone = gap_document(replace(diagnoses["no_gap"], untold=untold, detectable=[])).html()
    assert "cannot be told here: as well" in alone, "though no other effect was asked about"
    plain = gap_document(diagnoses["no_gap"]).html()
    assert "cannot be told here" not in plain and "may have changed" not in plain
    since = {"<valve>.setting": "155 bar"}
    sound = diagnoses["no_gap"]
    said = gap_document(replace(sound, sentence=sentence(sound.report, EFFECTS, BesideReport(since=since)))).html()
    assert re.search(r'<p class="verdict good">No gap: [^<]* likely\. <span>But &lt;valve&gt;\.setting may have changed [^<]*</span>', said)


def test_what_ends_farther_off_than_it_was_is_named_on_the_card(diagnoses):
    rows = {"temperature/motor_housing": {"unit": "K", "before": 0.139, "after": 0.182, "noise": 0.1},
            "speed": {"unit": "rad/s", "before": 0.05, "after": 0.1, "noise": 0.1},
            "temperature/tank_wall": {"unit": "K", "before": 0.185, "after": 0.135, "noise": 0.1}}
    gap = {"as_is": 7.0, "before": 1.3877, "after": 1.1, "closed_fraction": 0.7238}
    found = replace(diagnoses["no_gap"], report={**diagnoses["no_gap"].report, "shrink": rows, "gap": gap}, traces={})
    said = gap_document(found).html()
    assert "<small>farther off than before: temperature, motor housing 1.39 → 1.82</small>" in said
    assert "<small>noise floor; 72 % of the way from 1.39 to 1</small>" in said
    assert any("1 of 3 end within 1.2 times their floor, 1 farther off than before" in line.plain for line in gap_summary(found))
    better = {**rows, "temperature/motor_housing": {"unit": "K", "before": 0.182, "after": 0.139, "noise": 0.1}}
    assert "farther off" not in gap_document(replace(found, report={**found.report, "shrink": better})).html()


def test_each_table_of_flows_says_what_a_plus_is(diagnoses):
    explained = replace(diagnoses["explained"], inputs=[Lack("pump_1", "hydraulic", "lifting", "", -3.0e-6, 1e-7, "m3/s", 1.0)])
    said = " ".join(Page(gap_document(explained).html()).words)
    assert "is its leak here: a plus means that more passes it, and less is delivered." in said
    assert "what the pump delivers to the piston side, so that a leak is a minus here" in said
    filled = replace(explained, added=("learned.pump_1_unfilled_by_speed",))
    assert "its suction does not fill it is what is delivered." in " ".join(Page(gap_document(filled).html()).words)
    assert "is its leak here" not in " ".join(Page(gap_document(diagnoses["no_gap"]).html()).words), "no flow is missing"


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
                moved = sum(v["value"] - (v["nominal"] or 0.0) for v in row.get("parameters", {}).values())
                assert all(words in said for words in (known.happens(moved, True), known.law, known.signature, known.check))
        for name, row in diagnosis.report["shrink"].items():
            assert f"{row['before'] / row['noise']:.2f}" in said and f"{row['after'] / row['noise']:.2f}" in said, name
        for parameter in diagnosis.parameters:
            assert parameter.name in said and in_file(parameter.value, parameter.std) in said
            if parameter.name in diagnosis.rig.quantities:
                assert diagnosis.rig.quantities[parameter.name].source in said


@pytest.mark.parametrize(("together", "bars"), [(0.95, 0), (0.99, 1)])
def test_a_probability_is_told_twice_only_where_it_is_another_number(together, bars, diagnoses):
    made = diagnoses["explained"]
    leading = replace(made.weighed[0], probability=0.942)
    why = [{**made.report["why"][0], "probability": together}]
    said = gap_document(replace(made, weighed=[leading, *made.weighed[1:]], report={**made.report, "why": why})).html()
    assert said.count("<span>94 %</span>") == 1  # the card
    assert said.count(f"<span>{100 * together:.0f} %, ") == said.count("Of each effect, alone or beside others") == bars


def of_several_places():
    """Most single evidence in the sensors, most together in the relief valve."""
    rows = [Lack("sensor", "measurement", "all", "", 2.0, 0.1, "K", 0.4, signals=("temperature/motor_housing", "rod_position")),
            Lack("relief_valve", "hydraulic", "holding", "", 1e-6, 1e-7, "m3/s", 0.35),
            Lack("relief_valve", "hydraulic", "lifting", "", 2e-6, 1e-7, "m3/s", 0.25)]
    where = [{"component": r.component, "domain": r.domain, "phase": r.phase, "share": r.share, "missing": r.value, "unit": r.unit,
              "std": r.std} for r in rows]
    diagnosis = made_diagnosis("unknown")
    return replace(diagnosis, report={**diagnosis.report, "where": where}, lacking=rows)


def test_card_drawing_and_terminal_name_the_same_place_first():
    diagnosis = of_several_places()
    page = " ".join(" ".join(Page(gap_document(diagnosis).html()).words).split())
    assert "Relief valve 60 % of the evidence; hydraulic, most in holding" in page
    assert "Relief valve: 60 % of the evidence, hydraulic, most in holding; sensor: 40 % of the evidence, measurement, " \
           "mean of all phases, in readings of temperature, motor housing and of stroke error." in page
    told = " ".join(" ".join(line.plain for line in gap_summary(diagnosis)).split())
    assert "where 60 % relief valve: 35 % hydraulic, holding, +0.0600 ± 0.0060 L/min 40 % sensor: measurement, mean, +2.00" in told


@pytest.mark.parametrize(("size", "large"), [(410.0, "about 410 N"), (0.0, "something")])
def test_what_is_unknown_is_told_with_its_size_and_drawn_in_its_signal(size, large, diagnoses):
    diagnosis = diagnoses["unknown"]
    found = {**diagnosis.report["unknown"], "size": size}
    shapes = [replace(shape, signal="pressure_rod_side", unit="Pa") for shape in diagnosis.shapes]
    said = unknown_part(replace(diagnosis, report={**diagnosis.report, "unknown": found}, shapes=shapes))
    assert f"Cylinder, mechanical: {large} that no effect of the catalogue explains." in said
    assert said.count(">measured − twin, pressure, rod side, bar<") == len(shapes) > 0


@pytest.mark.parametrize("commissioned", [True, False])
def test_a_cause_is_told_against_what_it_was_counted_from(commissioned, diagnoses):
    diagnosis = diagnoses["explained"]
    ids, values = ("tank.oil_level",), {"tank.oil_level": (1.2, 0.1, "1", 1.0)}
    recordings = {kind: paths for kind, paths in diagnosis.recordings.items() if commissioned or kind != "commissioning"}
    said = hypotheses(replace(diagnosis, recordings=recordings, weighed=[Weighed(ids, 0.9, 1.0, values, {}, {})]))
    assert ("There is more oil in the tank than at commissioning." in said) == commissioned
    assert ("There is more oil in the tank than the sheet says." in said) != commissioned


def test_reasons_and_the_next_test_are_there(diagnoses):
    said = " ".join(Page(gap_document(diagnoses["ambiguous"]).html()).words)
    assert all(reason in said for reason in diagnoses["ambiguous"].confusable.values())
    assert "Run the uncoupled motor at 1000 rpm for ten minutes." in said and "7.5" in said and "about 1 808 times" in said
    assert "pump 1: friction from motor: bearing friction" in said


@pytest.mark.parametrize(("size", "said", "not_said"), [
    (0.3, "It would hardly tell load: mass from load: geometry and from no effect.", "It tells"),
    (7.5, "It tells load: mass from load: geometry and from no effect.", "hardly"),
])
def test_a_test_that_would_not_decide_is_not_praised(size, said, not_said, diagnoses):
    test = {"description": "Lift.", "between": ["load.mass", "load.geometry", "no effect"], "expected_separation": size}
    diagnosis = diagnoses["ambiguous"]
    words = " ".join(Page(gap_document(replace(diagnosis, report={**diagnosis.report, "next_test": test})).html()).words)
    assert said in words and not_said not in words
    assert ("hardly higher than before" in words) == (size < 1.0)


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
    assert chart["y"][0][1] < 40.0 and "°C; below: their difference, K" in page
    assert "measured − twin, K against oil temperature, °C" in page and "missing, K" not in page
    assert "oil temperature 22.9 to 29.9 °C" in page


def test_an_hour_stays_below_eight_megabytes():
    diagnosis = made_diagnosis("explained", seconds=3600.0)
    traces = {f"{n}_{i}": t for i in range(2) for n, t in diagnosis.traces.items()}
    page = gap_document(replace(diagnosis, traces=traces)).html()
    assert len(Page(page).charts) == 2 * len(diagnosis.traces)
    assert len(page.encode()) < 8e6


def card(diagnosis, title):
    """The number of a card of the page's head, None where it is not there."""
    found = re.search(rf"<dt>{title}</dt>\s*<dd>([^<]*)", gap_document(diagnosis).html())
    return found and found[1].strip()


@pytest.mark.parametrize(("kind", "added", "title"), [
    ("explained", ("pump_1.leakage",), "With the cause added"), ("unknown", ("learned.motor_heat",), "With a learned term"),
    ("unknown", ("load.mass",), "With the best listed hypothesis"), ("unknown", (), "Parameters refitted"),
])
def test_the_gap_at_the_end_is_called_after_what_was_added(kind, added, title, diagnoses):
    gap = {**diagnoses[kind].report["gap"], "after": 1.34}
    diagnosis = replace(diagnoses[kind], added=added, report={**diagnoses[kind].report, "gap": gap})
    assert card(diagnosis, title) == "1.34 ×"
    assert title == "With the cause added" or card(diagnosis, "With the cause added") is None


@pytest.mark.parametrize("kind", ["explained", "ambiguous", "unknown"])
def test_a_gap_without_a_size_is_said_to_be_astray(kind, diagnoses):
    given, first = diagnoses[kind], diagnoses[kind].weighed[0]
    gap = {"as_is": None, "before": None, "after": None, "closed_fraction": None}
    weighed = [replace(first, gap_after=math.inf, left={"current": math.inf}), *given.weighed[1:],
               Weighed(("a.b",), 0.001, math.inf, {}, {}, {})]
    diagnosis = replace(given, report={**given.report, "gap": gap}, weighed=weighed, added=("pump_1.leakage",))
    assert card(diagnosis, "Gap as given") == card(diagnosis, "Parameters fitted") == "astray"
    page, terminal = gap_document(diagnosis).html(), " ".join(line.plain for line in gap_summary(diagnosis))
    assert "With it free runs of held-out data go astray." in page and "– times" not in page and "nan" not in page
    assert "astray unfitted, astray fitted, astray with" in terminal


def test_what_speaks_most_strongly_against_is_named_first(diagnoses):
    leader = diagnoses["explained"].weighed[0]
    gains = {"pressure_piston_side": 4e5, "speed": -5.0, "current": -300.0, "voltage": -27.0, "electrical_power": -9.0}
    diagnosis = replace(diagnoses["explained"], weighed=[replace(leader, gains=gains)])
    said = " ".join(Page(gap_document(diagnosis).html()).words)
    assert "Against it current fits worse (strong); voltage fits worse (clear); electrical power fits worse (some)" in said
    assert "pressure, piston side (overwhelming, 100 % of the evidence)" in said


def test_no_effect_has_its_gap_shown_and_no_evidence(diagnoses):
    one = Weighed((), 0.001, 2.2, {}, {"speed": 0.0, "current": 0.0}, {"speed": 1.0, "current": 1.1})
    folded = gap_document(replace(diagnoses["explained"], weighed=[*diagnoses["explained"].weighed[:1], one])).html()
    assert "2.20" in re.sub(r"<details.*?</details>", "", folded, flags=re.DOTALL)
    alone = gap_document(replace(diagnoses["no_gap"], weighed=[replace(one, probability=0.9)])).html()
    assert "Evidence signal by signal" not in alone and "Against it" not in alone


def test_no_gap_does_not_contradict_what_is_left_open_and_what_rivals_lack(diagnoses):
    none = Weighed((), 0.92, 1.1, {}, {"speed": 0.0}, {"speed": 1.0, "rod_position": 2.3, "temperature/motor_winding": 2.8})
    rival = Weighed(("motor.resistance",), 0.07, 1.1, {}, {"current": 5.0}, {"speed": 1.0})
    report = {**diagnoses["no_gap"].report, "hypotheses": [{"effects": list(w.effects), "probability": w.probability, "gap_after": 1.1}
                                                           for w in (none, rival)]}
    lack = Lack("motor", "electrical", "all", "", 22.9, 5.8, "W", 0.83)
    found = replace(diagnoses["no_gap"], report=report, weighed=[none, rival], lacking=[lack], alone=[lack])
    said = " ".join(" ".join(Page(gap_document(found).html()).words).split())
    assert "No place is marked, as that no effect acts is likelier (92 %) than that any does. What would be missing if one did" in said
    assert "all but 2 of 3 signals, which it leaves open: temperature, motor winding 2.8 times its floor, stroke error 2.3 times" in said
    assert "What would be missing if one did stands under 'What the twin would lack if something acted'." in said
    assert said.count("Would be missing ± std") == said.count("How sure if something acts there") == 2
    assert "What the twin lacks" not in said and " Missing ± std" not in said
    assert "That no effect acts is likelier than all that stands here." in said and "If one of the less likely hypotheses held" in said
    assert "From the data alone, each place as if it acted by itself" in said
    assert not any(words in said for words in ("Nothing is missing", "Nothing is left", "Given the hypotheses"))
    plain = " ".join(" ".join(Page(gap_document(diagnoses["no_gap"]).html()).words).split())
    assert "What would be missing if one did" not in plain
    assert "parameters fitted within 2.5 times their tolerances, the sensors' zero errors and noise explain what was recorded." in plain


def test_parameters_at_the_end_of_their_tolerance_are_those_of_the_answer(diagnoses):
    one, two = (replace(p, value=p.prior - 2.5 * p.prior_std) for p in diagnoses["explained"].parameters[:2])
    drawn = replace(diagnoses["explained"].parameters[2], value=0.9 + 2.5 * 0.05)
    assert one.informed and two.informed and not drawn.informed
    said = " ".join(Page(gap_document(replace(diagnoses["no_gap"], parameters=[one, drawn, two])).html()).words)
    named = re.search(r"so that the answer names them: (.*?)\. At 2.5 too, but drawn .*?: (.*?)\.\s", said)
    assert named.groups() == (f"{one.name}, {two.name}", drawn.name)
    assert "answer names them" not in " ".join(Page(gap_document(diagnoses["no_gap"]).html()).words)


def test_what_an_effect_made_of_a_parameter_stands_beside_what_was_fitted(diagnoses):
    diagnosis = diagnoses["explained"]
    leakage = replace(diagnosis.rig.quantities["pump_1.leakage"], value=2.05e-12, std=8e-14, source="effect pump_1.leakage, fitted to x")
    rig = replace(diagnosis.rig, quantities={**diagnosis.rig.quantities, "pump_1.leakage": leakage})
    said = " ".join(Page(gap_document(replace(diagnosis, rig=rig)).html()).words)
    assert "(1.120 ± 0.040)e-12 (2.050 ± 0.080)e-12 effect pump_1.leakage" in " ".join(said.split())
    assert "-o writes them with it" not in " ".join(Page(gap_document(replace(diagnosis, rig=rig, added=())).html()).words)


def test_a_parameter_has_the_source_of_the_value_that_stands_beside_it(diagnoses):
    diagnosis = diagnoses["explained"]
    sources = {p.name: "fitted to new, field" for p in diagnosis.parameters}
    sources["pump_1.leakage"] = "effect pump_1.leakage, fitted to new, field"
    rig = replace(diagnosis.rig, quantities={name: replace(q, source=sources.get(name, q.source))
                                             for name, q in diagnosis.rig.quantities.items()})
    fitted = gap_document(replace(diagnosis, rig=rig)).html().partition("<h2>Parameters of the rig")[2]
    said = " ".join(re.sub(r"<[^>]+>", " ", fitted).split())
    assert "Fitted to the commissioning and the field recordings together, with the cause added; the values leave out what it does." in said
    assert "Source, where no other is named: fitted to new, field." in said
    assert said.count("effect pump_1.leakage, fitted to") == 1, "beside the value that has the effect in it, and not beside that without"
    built = replace(rig, quantities={name: replace(q, source="fitted to bags/new") for name, q in rig.quantities.items()})
    other = gap_document(replace(diagnoses["unknown"], rig=built, nameless=True)).html().partition("<h2>Parameters of the rig")[2]
    assert "-o writes those of the commissioning recording alone" in other
    assert "where no other is named: fitted to bags/new, bags/field &lt;1&gt;." in other


@pytest.mark.parametrize(("kind", "last"), [
    ("explained", "With the cause added: they are fitted to both recordings, too; the table of parameters at the end is of this fit."),
    ("no_gap", "The table of parameters at the end is of this second fit."),
])
def test_the_head_says_of_which_fit_the_table_of_parameters_is(kind, last, diagnoses):
    assert last in gap_document(diagnoses[kind]).html()


@pytest.mark.parametrize(("value", "std", "said"), [
    (2900.0, 290.0, "2900 ± 290"), (1.9e-12, 6.5e-14, "(1.900 ± 0.065)e-12"), (0.0, 6e4, "0 ± 60000"), (0.0, 0.0, "0"),
])
def test_values_of_the_rig_file_have_the_digits_that_their_spread_allows(value, std, said):
    assert in_file(value, std) == said


def test_a_missing_sample_and_a_signal_without_any_do_not_break_the_page(diagnoses):
    diagnosis = diagnoses["explained"]
    speed = diagnosis.traces["speed"]
    holes = replace(speed, measured=np.where(np.arange(speed.time.size) % 3 == 0, np.nan, speed.measured))
    none = replace(speed, **{n: np.zeros(0) for n in ("time", "measured", "before", "after")})
    page = Page(gap_document(replace(diagnosis, traces={"speed": holes, "current": none})).html())
    assert len(page.charts) == 1 and not page.open


@pytest.mark.parametrize(("effects", "unknown", "told"), [
    (("pump_1.leakage", "load.mass"), UNLISTED, True), ((), UNLISTED, False), (("pump_1.leakage",), UNLISTED, True),
    (("pump_1.leakage", "load.mass"), 0.4, False),
])  # fmt: skip
def test_what_is_always_left_beside_an_effect_is_told(effects, unknown, told, diagnoses):
    weighed = [Weighed(effects, 0.99 - unknown, 1.0, {}, {}, {}), Weighed(("unknown",), unknown, None, {}, {}, {})]
    page = gap_document(replace(diagnoses["ambiguous"], weighed=weighed)).html()
    assert (f"Where an effect leads, {100.0 * UNLISTED:.0f} % is always left to such a cause" in page) == told


def test_that_causes_may_hide_is_told_beside_no_gap_alone(diagnoses):
    weighed = [Weighed((), 0.6, 1.0, {}, {}, {}), Weighed(("unknown",), 0.1, None, {}, {}, {})]
    pages = (gap_document(replace(diagnoses[verdict], weighed=weighed)).html() for verdict in ("no_gap", "explained"))
    assert ["these recordings would hardly show; the less" in page for page in pages] == [True, False]


def test_every_check_that_a_rule_makes_has_words(repo_root):
    rules = "".join(file.read_text() for file in (repo_root / "ddh_twin_py/ddh_twin_py/gap").rglob("*.py"))
    assert set(re.findall(r'(?:checked|Check)\("(\w+)"', rules)) == set(CHECKS)


@pytest.mark.parametrize("kind", KINDS)
def test_the_page_says_what_a_hypothesis_had_to_bear_and_how_near_it_came(kind, diagnoses):
    page = Page(gap_document(diagnoses[kind]).html())
    said = " ".join(page.words)
    assert ("What it had to bear" in page.headings) is (kind != "insufficient")
    said, asked = " ".join(said.split()), kind != "insufficient"
    assert ("Must the rig have changed beside it?" in said and "0.50 standard deviations farther from the rig as" in said) is asked
    assert ("stay off in the held-out data? ▲ yes the farthest is 2.40 × its floor off" in said) is (kind == "unknown")
    assert ("another size would gain nothing" in said) is asked
    assert "'Nearly' is" not in said


def bears(diagnosis, check, measured, limit):
    """The row of one check, in words."""
    given = {**diagnosis.report, "checks": [{"effects": ["load.mass"], "check": check, "measured": measured, "limit": limit}]}
    table = checks_of(replace(diagnosis, report=given)).partition("<tbody>")[2].partition("</tbody>")[0]
    return [re.sub(r"<[^>]+>", "", cell).strip() for cell in re.findall(r"<t[hd].*?</t[hd]>", table)][1:]


@pytest.mark.parametrize(("check", "measured", "limit", "said"), [
    ("displaced", -1.52, 1.5, ["● no", "no farther from the rig as fitted than is to be expected", "1.50 deviations"]),
    ("displaced", 1.6, 1.5, ["▲ yes", "1.60 standard deviations farther from the rig as fitted than is to be expected", "1.50 deviations"]),
    ("outdone", -24367.63, 2446.77, ["● no", "no place explains more", "2447 points"]),
    ("outdone", 24367.63, 2446.77, ["▲ yes", "more by 24368 points of evidence", "2447 points"]),
    ("worsened", 0.0, 1.1, ["● no", "none is off by a fifth more than without it", "1.10 × floor"]),
    ("strained", 1.0, 1.08, ["● no", "the fast signal that is farthest off is 1.00 × its floor off", "1.08 × floor"]),
    ("refuted", -0.07, 0.05, ["● no", "not wider than without it", "0.05 × floor"]),
    ("structure", -9.0, -2.0, ["● no", "such a law would gain nothing", "−2.00 points"]),
    ("structure", 5.0, -2.0, ["▲ yes", "such a law would gain 5.00 points of evidence", "−2.00 points"]),
    ("structure", -9.0, 0.0, ["● no", "such a law would gain nothing", "0.00 points"]),
])
def test_what_was_measured_is_a_phrase_and_no_number_where_it_is_less_than_expected(check, measured, limit, said, diagnoses):
    assert bears(diagnoses["explained"], check, measured, limit) == said


@pytest.mark.parametrize("check", sorted({name for name, check in CHECKS.items() if check.nothing == 0.0} - {"cancelling"}))  # a share
def test_a_negative_number_is_never_shown_as_what_a_hypothesis_had_to_bear(check, diagnoses):
    assert not re.search(r"\d.*(floor|deviations|points)|−", bears(diagnoses["explained"], check, -3.0, 2.0)[1])


def test_of_two_effects_each_value_is_named_with_its_own(diagnoses):
    pumps = {"pump_1.leakage": (0.578, 0.043, "1", 1.0), "pump_2.leakage": (0.968, 0.018, "1", 1.0)}
    two = [Weighed(tuple(pumps), probability, 1.0, pumps, {}, {}) for probability in (0.9, 0.005)]
    said = hypotheses(replace(diagnoses["explained"], weighed=two))
    assert re.findall(r'class="found">(.*?)<strong>(.*?)</strong>', said) == [
        ("Pump 1: leakage, leakage ratio: ", "0.578 ± 0.043"), ("Pump 2: leakage, leakage ratio: ", "0.968 ± 0.018")]
    assert "pump 1: leakage 0.578 ± 0.043; pump 2: leakage 0.968 ± 0.018" in said
    alone = hypotheses(diagnoses["explained"])
    assert '<p class="found">Leakage ratio: <strong>' in alone, "which effect stands in the line above"


def test_what_is_nearly_is_said_where_something_is(diagnoses):
    near = replace(diagnoses["explained"], report={**diagnoses["explained"].report, "checks": [
        {"effects": ["load.mass"], "check": "drifted", "measured": 7.0, "limit": 8.0}]})
    assert "nearly 7.00 standard deviations" in (said := " ".join(" ".join(Page(gap_document(near).html()).words).split()))
    assert "'Nearly' is three quarters of the way" in said
