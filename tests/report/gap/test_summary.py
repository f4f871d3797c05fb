"""The terminal's summary of a gap diagnosis: 25 lines of 80 columns, and the report's numbers."""

import io
from dataclasses import replace

import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.report.gap.summary import LINES, _hypotheses, _notes, _weighed, print_gap
from ddh_twin_py.report.gap.words import set_name, signal_name
from rich.console import Console
from support.made_diagnosis import KINDS, made_diagnosis


def rendered(diagnosis, width=80):
    """What a terminal of so many columns shows; a file with None."""
    out = io.StringIO()
    print_gap(diagnosis, Console(file=out, width=width, force_terminal=width is not None, color_system=None))
    return out.getvalue().splitlines()


@pytest.mark.parametrize("kind", KINDS)
def test_fits_a_terminal(kind):
    lines = rendered(made_diagnosis(kind, seconds=120.0))
    assert 1 <= len(lines) <= LINES and max(map(len, lines)) <= 80
    assert not any("\x1b" in line for line in lines)
    assert not any("…" in line for line in lines if line.startswith(("gap", "signals")))


def test_stays_within_it_where_everything_is_long():
    diagnosis = made_diagnosis("ambiguous", seconds=120.0)
    report = {
        **diagnosis.report, "notes": ["a long note " * 40] * 9, "classes": [list(EFFECTS)[:12]],
        "next_test": {"description": "a long test " * 30, "expected_separation": 3.0},
        "gap": {"as_is": 35.54, "before": 13.39, "after": 11.25, "closed_fraction": 0.17},
    }
    longest = tuple(sorted(EFFECTS, key=len)[-2:])
    weighed = [replace(w, effects=longest, probability=0.2) for w in diagnosis.weighed * 3]
    lines = rendered(replace(diagnosis, report=report, weighed=weighed, sentence="a long sentence " * 40))
    assert len(lines) <= LINES and max(map(len, lines)) <= 80
    assert "(17 % closed from 13.39)" in " ".join(" ".join(lines).split())


def test_the_next_test_is_told_to_its_end_and_lost_data_come_first():
    diagnosis = made_diagnosis("ambiguous", seconds=120.0)
    told = "3 min of lifting 145.3 kg at 1200 rpm and lowering it at 1200 rpm between 0.02 and 0.37 m, with 1 s of rest at each end, " \
           "begun with the unit as cold as its surroundings (21 degC). It would not tell load.mass from load.geometry."
    cut = "bags/cut is cut off; recovered 14569 of 40499 messages, 324 s"
    report = {**diagnosis.report, "notes": ["first note", cut, "a long note " * 20, "fourth", "fifth"],
              "next_test": {"description": told, "between": [], "expected_separation": 3.0}}
    lines = rendered(replace(diagnosis, report=report))
    said = " ".join(" ".join(lines).split())
    assert told in said and cut in said and len(lines) <= LINES
    assert said.index(cut) < said.index("gap ") and said.index(cut) < said.index("first note")


@pytest.mark.parametrize(("count", "said"), [(1, "another"), (2, "and 2 further notes in the report")])
def test_notes_without_room_are_counted(count, said):
    lines = [line.plain for line in _notes(["one", "two " * 30, *["another"] * count], 4)]
    assert lines[0] == "note       one" and said in lines[-1] and len(lines) == 4 and "1 further" not in lines[-1]


def with_long_words():
    diagnosis = made_diagnosis("ambiguous", seconds=120.0)
    longest = tuple(sorted(EFFECTS, key=len)[-2:])
    notes = [f"note {n} " + "with many words " * 20 + f"ends {n}." for n in range(5)]
    report = {**diagnosis.report, "notes": notes, "next_test": {"description": "a test " * 99 + "ends", "expected_separation": 3.0}}
    return replace(diagnosis, report=report, weighed=[replace(diagnosis.weighed[0], effects=longest, probability=0.9)]), longest, notes


def test_nothing_is_cut_in_a_file():
    diagnosis, longest, notes = with_long_words()
    lines = rendered(diagnosis, None)
    assert len(lines) <= LINES and not any("…" in line or "further notes" in line for line in lines)
    said = " ".join(" ".join(lines).split())
    assert all(note in said for note in notes) and set_name(longest) in said and "a test ends" in said
    assert "…" in " ".join(rendered(diagnosis, 80))


def test_a_terminal_is_used_as_wide_as_it_is():
    diagnosis, longest, _ = with_long_words()
    wide = rendered(diagnosis, 160)
    assert 80 < max(map(len, wide)) <= 160 and len(wide) <= LINES and max(map(len, rendered(diagnosis, 70))) <= 70
    at = next(i for i, line in enumerate(wide) if line.startswith("cause"))
    assert set_name(longest) in wide[at]


def test_a_long_hypothesis_goes_on_in_a_second_line():
    diagnosis = made_diagnosis("explained", seconds=120.0)
    longest = tuple(sorted(EFFECTS, key=len)[-2:])
    lines = rendered(replace(diagnosis, weighed=[replace(diagnosis.weighed[0], effects=longest)]))
    at = next(i for i, line in enumerate(lines) if line.startswith("cause"))
    assert set_name(longest) in " ".join(" ".join(lines[at : at + 2]).split()) and set_name(longest) not in lines[at]


def test_what_to_be_careful_of_is_a_sentence_of_its_own():
    diagnosis = made_diagnosis("no_gap", seconds=120.0)
    careful = replace(diagnosis, sentence="Careful: the clocks are 2 s apart. No gap: with its parameters fitted nothing is left.")
    said = " ".join(" ".join(rendered(careful)).split())
    assert said.startswith("No gap. Careful: the clocks are 2 s apart. With its parameters fitted nothing is left.")


def test_numbers_are_those_of_the_report():
    diagnosis = made_diagnosis("explained", seconds=300.0)
    lines = rendered(diagnosis)
    said = " ".join(" ".join(lines).split())
    assert diagnosis.sentence in said and f"Explained: {diagnosis.sentence}" in said
    for key in ("as_is", "before", "after"):
        assert f"{diagnosis.report['gap'][key]:.2f}" in said
    assert any("98 %  pump 1: leakage, leakage ratio 1.830 ± 0.040" in line for line in lines)
    assert [line.strip() for line in lines].count("± is one standard deviation") == 1
    row = diagnosis.report["shrink"]["pressure_piston_side"]
    line = next(line for line in lines if signal_name("pressure_piston_side") in line)
    assert f"{row['before'] * 1e-5:.3f} → {row['after'] * 1e-5:.3f} bar" in line
    assert line.split()[-1] == f"{row['after'] / row['noise']:.2f}"


@pytest.mark.parametrize(("width", "most", "said"), [
    (80, 2, "pump 1: leakage (leakage ratio 0.578 ± 0.043) and pump 2: leakage (leakage ratio 0.968 ± 0.018)"),
    (100, 1, "pump 1: leakage (0.578 ± 0.043) and pump 2: leakage (0.968 ± 0.018)"),
])
def test_each_of_two_effects_has_its_value_beside_it(width, most, said):
    diagnosis = made_diagnosis("explained", seconds=120.0)
    pumps = {"pump_1.leakage": (0.578, 0.043, "1", 1.0), "pump_2.leakage": (0.968, 0.018, "1", 1.0)}
    both = [replace(diagnosis.weighed[0], effects=tuple(pumps), values=pumps)]
    lines = _hypotheses(replace(diagnosis, weighed=both), width, most)
    assert said in " ".join(" ".join(line.plain for line in lines).split())


@pytest.mark.parametrize(("built", "said"), [
    (["bags/new"], "floor: what a fitted twin misses of the rig as built, at least noise"),
    ([], "floor: 1.6 times the sensors' noise; the rig as built is not recorded"),
])  # fmt: skip
def test_the_floor_is_explained_below_the_gap_where_a_line_is_left(built, said):
    diagnosis = made_diagnosis("explained", seconds=120.0)
    recordings = {kind: own for kind, own in {**diagnosis.recordings, "commissioning": built}.items() if own}
    diagnosis = replace(diagnosis, recordings=recordings)
    lines = rendered(diagnosis)
    (at,) = (i for i, line in enumerate(lines) if line.strip() == said)
    assert "× floor unfitted" in "".join(lines[at - 2 : at]) and lines[at + 1].startswith("cause")
    full = {**diagnosis.report, "notes": [f"x; recovered {n} " + "much " * 40 for n in (1, 2)], "classes": [list(EFFECTS)[:12]],
            "next_test": {"description": "a long test " * 34 + "ends", "expected_separation": 3.0}}
    lines = rendered(replace(diagnosis, report=full, sentence="a long sentence " * 40))
    assert "floor:" not in " ".join(lines) and lines[-1].endswith("ends")


def test_nothing_is_claimed_where_nothing_is_known():
    said = " ".join(rendered(made_diagnosis("insufficient")))
    assert said.startswith("Cannot tell") and "12 s of motion" in said and "floor" not in said


def test_a_value_and_its_deviation_stand_in_one_line():
    words = "pump 1: leakage and relief valve: seat leakage  1.728 ± 0.079; 0.097 ± 0.065 mL/(min·bar)"
    first, second = (line.plain for line in _weighed("cause", "2 %", words, 80, 2))
    assert first.endswith("seat leakage") and second.strip() == "1.728 ± 0.079; 0.097 ± 0.065 mL/(min·bar)"


def test_signals_that_stay_off_their_floor_are_named():
    diagnosis = made_diagnosis("explained", seconds=120.0)
    names = list(diagnosis.report["shrink"])
    rows = {name: {**diagnosis.report["shrink"][name], "noise": 1.0, "before": 9.0 - i, "after": 0.9} for i, name in enumerate(names)}
    rows[names[-1]] |= {"before": 1.31, "after": 1.29}
    rows[names[-2]] |= {"before": 1.46, "after": 1.45}
    said = " ".join(" ".join(rendered(replace(diagnosis, report={**diagnosis.report, "shrink": rows}))).split())
    stay = f"not: {signal_name(names[-2])} 1.45, {signal_name(names[-1])} 1.29"
    assert f"{len(names) - 2} of {len(names)} signals end within 1.2 times their floor; {stay}" in said
    full = {**diagnosis.report, "shrink": rows, "notes": [f"x; recovered {n} " + "much " * 40 for n in (1, 2)],
            "next_test": {"description": "a long test " * 34 + "ends", "expected_separation": 3.0}}
    lines = rendered(replace(diagnosis, report=full, sentence="a long sentence " * 40))
    at = next(i for i, line in enumerate(lines) if line.startswith("signals"))
    assert stay in " ".join(" ".join(lines[at:]).split()) and len(lines) <= LINES
    assert stay in " ".join(rendered(replace(diagnosis, report=full), None))
