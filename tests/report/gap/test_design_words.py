"""How a test's design is put into one sentence."""

import io
import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest
from ddh_twin_py.gap.drive.design import Design
from ddh_twin_py.gap.explain.detection import SIZES, Detection
from ddh_twin_py.report.gap.design_page import design_document
from ddh_twin_py.report.gap.design_summary import print_design
from ddh_twin_py.report.gap.design_words import impossible, smallest, verdict
from ddh_twin_py.rig import load_rig
from rich.console import Console


def a_design(seen, classes):
    effects = ("pump_1.leakage", "load.mass", "tank.cooling")
    found = [Detection(e, "1", 0.1, 1.0, "current", dict.fromkeys(SIZES, 5.0 if e in seen else 0.0)) for e in effects]
    return Design(120.0, 600.0, (), True, found, list(effects), np.zeros((3, 3)), classes)


@pytest.mark.parametrize(("seen", "classes", "said"), [
    ((), [], "detects 0 of 3 effects."),
    (("load.mass",), [], "detects 1 of 3 effects."),
    (("load.mass", "tank.cooling"), [], "detects 2 of 3 effects and tells each of them from all others that it detects."),
    (("load.mass", "tank.cooling", "pump_1.leakage"), [["load.mass", "tank.cooling"]],
     "detects 3 of 3 effects; 1 of these is told from every other one that it detects, the others form 1 class."),
])
def test_the_sentence_counts_what_is_detected_and_told_apart(seen, classes, said):
    assert verdict(a_design(seen, classes))[0].endswith(said)


@pytest.mark.parametrize(("effect", "unit", "size", "said", "short"), [
    ("pump_1.leakage", "1", 0.0391, "leakage ratio +0.0391", "ratio +0.0391"),
    ("line_b.pressure_drop", "Pa*s2/m6", 6.5e12, "quadratic coefficient +0.0181 bar/(L/min)²", "+0.0181 bar/(L/min)²"),
    ("load.mass", "kg", None, "–", "–"),
])
def test_the_smallest_departure_is_one_of_a_quantity(effect, unit, size, said, short):
    found = Detection(effect, unit, size, 1.0, "current", dict.fromkeys(SIZES))
    assert smallest(found) == said and smallest(found, short=True) == short


@pytest.mark.parametrize(("effect", "worst", "said"), [
    ("sensor.temperature_lag", "", "no such sensor"), ("relief_valve.setting", "", "shows nowhere"),
    ("sensor.time_skew", "pressure_rod_side", "beyond bounds"),
])
def test_what_is_not_possible_says_why(effect, worst, said):
    assert impossible(Detection(effect, "1", None, None, worst, dict.fromkeys(SIZES))) == said


def test_effects_that_cannot_be_so_large_are_not_counted_as_missed():
    design = a_design(("load.mass", "tank.cooling"), [])
    small = replace(design.detections[2], gain={"faint": 5.0, "moderate": None, "clear": None})
    design = replace(design, detections=[*design.detections[:2], small])
    assert "detects 1 of 3 effects (1 cannot be so large or show nowhere)" in verdict(design)[0]
    page = design_document(design, load_rig(), "a duty", 1.0).html()
    assert "2 of 3" in page and page.count("1 of 2") == 2
    assert page.count("1 more cannot be so large, or show nowhere") == 2 and "these become fewer from faint to clear" in page


def test_page_and_terminal_have_the_same_numbers():
    design = replace(a_design(("load.mass", "tank.cooling"), []), separation=np.full((3, 3), 3561.3))
    out = io.StringIO()
    print_design(design, Console(file=out, width=100))
    page = design_document(design, load_rig(), "a duty", 1.0).html()
    for said in (">100", "ratio +0.1"):
        assert said in out.getvalue() and said in unescape(page)
    assert "3561" not in out.getvalue() + page and "Bayes" not in out.getvalue() + page
    heads = next(line.split() for line in out.getvalue().splitlines() if "smallest departure" in line)
    assert heads == ["effect", "smallest", "departure", *SIZES, "told"]
    assert "faint, moderate, clear: would it be detected where the worst signal rises to 2.2, 5, 11 times its noise" in " ".join(
        out.getvalue().split())


@pytest.mark.parametrize(("width", "most"), [(100, 81), (76, 76), (40, 76)])
def test_no_number_is_cut_however_narrow_the_terminal(width, most):
    effects = ["pump_1.leakage", "sensor.pressure_rod_side_offset"]
    found = [Detection(effect, "m3/(s*Pa)", 2.0e-10, 1.0, "current", dict.fromkeys(SIZES, 5.0)) for effect in effects]
    design = replace(a_design((), []), detections=found, names=effects, separation=np.full((2, 2), 97.4))
    out = io.StringIO()
    print_design(design, Console(file=out, width=width))
    said = "\n".join(line.rstrip() for line in out.getvalue().splitlines() if line)
    assert len(re.findall("  yes +yes +yes +97.4", said)) == said.count("+1200 mL/(min·bar)") == 2 and "…" not in said
    assert ("pump_1.leakage  " in said) == (width > 40) and ("sensor.pressure_rod_side_offset  " in said) == (width == 100)
    assert max(len(line) for line in out.getvalue().splitlines() if "yes" in line) <= most


def test_rows_of_what_is_not_detected_are_marked_and_explained():
    some = design_document(a_design(("load.mass", "tank.cooling"), []), load_rig(), "a duty", 1.0).html()
    assert ">pump 1: leakage ○  1<" in some and ">load: mass  2<" in some
    assert "○: this test does not detect the effect at a moderate size" in some and "counts in no class" in some
    every = design_document(a_design(("load.mass", "tank.cooling", "pump_1.leakage"), []), load_rig(), "a duty", 1.0).html()
    assert "○" not in every


def test_what_no_machine_reaches_has_neither_a_smallest_departure_nor_what_it_is_told_from():
    effects = ["load.mass", "motor.flange_conduction", "pump_1.cooling"]
    found = [Detection("load.mass", "kg", 2.0, 1.9, "current", dict.fromkeys(SIZES, 5.0)),
             Detection("motor.flange_conduction", "W/K", 99.8, 1.4, "current", dict.fromkeys(SIZES), beyond=True),
             Detection("pump_1.cooling", "1", None, None, "current", dict.fromkeys(SIZES))]
    design = replace(a_design((), []), detections=found, names=effects, separation=np.full((3, 3), 5.7))
    out = io.StringIO()
    print_design(design, Console(file=out, width=100))
    rows = {line.split()[0]: line.split()[1:] for line in out.getvalue().splitlines() if line.strip().startswith(tuple(effects))}
    assert rows == {"load.mass": ["+2.00", "kg", "yes", "yes", "yes", "5.7"], **{name: ["–"] * 5 for name in effects[1:]}}
    said = " ".join(out.getvalue().split())
    assert "odds of 20 to 1" in said and "Bayes" not in said
    page = design_document(design, load_rig(), "a duty", 1.0).html()
    assert "99.8" not in page and page.count("load: mass, 5.7") == 0 and page.count("motor: flange conduction, 5.7") == 1
