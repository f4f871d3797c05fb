"""The page and the tables of `ddh-twin study cold-start`."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

from ddh_twin_py.physics.motor import CUT_BACK_FROM
from ddh_twin_py.physics.oil import STATED_FROM, STATED_TO, ZERO_CELSIUS
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.heatmap import Cell, heatmap, on_scale
from ddh_twin_py.report.units import number, words
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.oil_grades import oil_grade
from ddh_twin_py.twin import cold_start as cold
from ddh_twin_py.twin.possible_speed import CURRENT_SHARE, SUCTION_MARGIN

FILLS = {
    "full at once": "#009e73", "reaches full speed": "#56b4e9", "stays slow": "#f0e442", "overheats": "#d55e00", "stuck": "#444444",
}
"""Colours of the verdicts (Okabe and Ito 2008), told apart without red and green too; each cell also says it in words."""
MEANING = {
    "full at once": "full speed is allowed at once", "reaches full speed": "reaches full speed by itself; the cell says when",
    "stays slow": "never reaches full speed", "overheats": "the winding passes its insulation limit; the cell says when",
    "stuck": "cannot move at all",
}
UNIT = {"ambient": "degC", "time": "s"}


def minutes(seconds: float) -> str:
    """A time in the cell of a map."""
    return "" if math.isnan(seconds) else f"{seconds:.0f} s" if seconds < 90.0 else f"{seconds / 60.0:.0f} min"


def label(o: cold.Outcome) -> str:
    """What stands in the cell of a map."""
    if o.verdict == "overheats":
        return "▲ " + minutes(o.time_over_limit)
    return {"full at once": "●", "stuck": "■", "stays slow": f"{100.0 * o.final_share:.0f} %"}.get(o.verdict) or minutes(o.time_to_full)


def flips(outcomes: Sequence[cold.Outcome]) -> list[tuple[str, str, str]]:
    """Duty, grade and in words what happens in which range of ambient: where the answer changes."""
    found = []
    for duty, grade in dict.fromkeys((o.case.duty, o.case.grade) for o in outcomes):
        line = sorted((o for o in outcomes if (o.case.duty, o.case.grade) == (duty, grade)), key=lambda o: o.case.ambient)
        parts: list[list[cold.Outcome]] = []
        for o in line:
            if parts and parts[-1][0].verdict == o.verdict:
                parts[-1].append(o)
            else:
                parts.append([o])
        found.append((duty, grade, "; ".join(map(_alike, parts))))
    return found


def _alike(outcomes: Sequence[cold.Outcome]) -> str:
    """In words what happens in a range of ambient, whose starts come out alike; of what overheats what and when."""
    a, b = outcomes[0].case.ambient, outcomes[-1].case.ambient
    said = f"{outcomes[0].verdict} at {a:g}" + (f" to {b:g}" if b != a else "") + " degC"
    if outcomes[0].verdict != "overheats":
        return said
    times = [minutes(f([o.time_over_limit for o in outcomes])) for f in (min, max)]
    return f"{said} (the winding, after {' to '.join(dict.fromkeys(times))})"


def verdict(outcomes: Sequence[cold.Outcome]) -> str:
    """One sentence for the whole sweep."""
    count = {name: sum(o.verdict == name for o in outcomes) for name in cold.VERDICTS}
    said = ", ".join(f"{name} {n}" for name, n in count.items() if n)
    return f"{len(outcomes)} starts: {said}."


def assumptions(rig: Rig, outcomes: Sequence[cold.Outcome], hours: float) -> list[str]:
    """What was taken for granted."""
    outside = sorted({o.case.ambient for o in outcomes if o.extrapolated})
    thick = sorted({o.case.grade for o in outcomes if o.case.ambient < oil_grade(o.case.grade).pour_point})
    dips = max((o.cavitating for o in outcomes if not tripped(o)), default=0.0)
    taken = [
        f"Everything starts at ambient; the unit does its duty for {hours:g} h. 'At the end' is after that time; a run whose winding "
        f"passes {CUT_BACK_FROM - ZERO_CELSIUS:g} degC ends there, since the drive trips, and has no steady temperatures.",
        f"Before each cycle the controller allows the highest speed that can be held with {100 * CURRENT_SHARE:g} % of the current limit "
        f"({rig['motor.current_limit']:g} A) and every port and chamber {SUCTION_MARGIN / 1e5:g} bar above the vapour pressure. It does "
        "not "
        "spare the winding: that is what 'overheats' tells.",
        f"Overheats: slot or end winding above {rig['motor.thermal.winding_limit']:g} degC at any time. The full speed may have been "
        "reached "
        "all the same; the table says so.",
        f"At the start of a stroke a pressure can dip to the vapour pressure before it settles: at most {100 * dips:.1f} % of a "
        "cycle in runs that do not trip.",
        "The model has no suction line between tank and pumps, so that the pumps' own suction from a cold tank is not judged.",
        "Leakage, viscous friction and line drop go with viscosity as the data sheet says; at hundreds of times the viscosity that they "
        "were stated "
        "for this is an extrapolation.",
        f"The Walther law is stated for {STATED_FROM - ZERO_CELSIUS:g} to {STATED_TO - ZERO_CELSIUS:g} degC."
        + (f" Viscosity is extrapolated for the starts at {', '.join(f'{t:g}' for t in outside)} degC." if outside else ""),
        f"Two rates: whole cycles by the free run, between them the thermal network with their mean heats, until the oil has changed by "
        f"{cold.OIL_BOUND:g} K.",
    ]
    if thick:
        taken.append(f"Below its pour point oil does not flow to a pump at all, whatever the drive could do; this concerns "
            f"{', '.join(thick)} (see oil_grades.yaml).")
    return taken


def cold_start_end(rig: Rig, outcomes: Sequence[cold.Outcome], hours: float, seconds: float) -> doc.EndMatter:
    """What the numbers rest on."""
    return doc.EndMatter("Nothing was fitted; every number is the model's with the rig file as it is.", rig.file,
                         assumptions(rig, outcomes, hours), [("Computing time", f"{seconds:.1f} s for {len(outcomes)} starts")])


def cold_start_document(rig: Rig, outcomes: Sequence[cold.Outcome], hours: float, seconds: float) -> doc.Document:
    """The page: per duty a map of what happens, of tank oil at the end and of the highest winding; the table."""
    page = doc.Document(
        kind="Study: cold start", title=f"{rig.rig_id}: can it keep itself warm?", verdict=verdict(outcomes), level="fair",
        end=cold_start_end(rig, outcomes, hours, seconds),
    )
    keys = "".join(f'<li><i style="background:{fill}"></i>{name}: {MEANING[name]}</li>' for name, fill in FILLS.items())
    page.add("How to read the maps", doc.paragraph(
        "Each cell is one start of a unit that has taken the ambient's temperature all through. Black lines stand where the answer "
        "flips. In cells: ● full speed at once, a time until full speed, ▲ and the time until the winding is too hot, ■ stuck; a number is "
        "a temperature, and where the drive trips before the end there is none."), doc.Html(f'<ul class="key">{keys}</ul>'))
    for duty in dict.fromkeys(o.case.duty for o in outcomes):
        these = [o for o in outcomes if o.case.duty == duty]
        page.add(
            f"Duty: {words(duty)}", _verdict_map(these),
            _number_map(these, "tank_oil", "Tank oil at the end, degC (lines as above)"),
            _number_map(these, "winding_peak", "Winding, highest of the run, degC (lines as above)"),
        )
    page.add("Where the answer flips", doc.table(
        [doc.Column(n, number=False) for n in ("Duty", "Oil", "What happens")], [(words(a), b, c) for a, b, c in flips(outcomes)]))
    page.add("All starts", doc.details("Table", _table(outcomes)))
    return page


def _grid(outcomes: Sequence[cold.Outcome]) -> tuple[list[float], list[str], dict]:
    ambients = sorted({o.case.ambient for o in outcomes})
    grades = sorted({o.case.grade for o in outcomes}, key=lambda name: oil_grade(name).viscosity(0.0))
    return ambients, grades, {(o.case.grade, o.case.ambient): o for o in outcomes}


def _map(outcomes: Sequence[cold.Outcome], cell, caption: str) -> doc.Html:
    ambients, grades, at = _grid(outcomes)
    return heatmap([f"{t:g}" for t in ambients], grades, [[cell(at[g, t]) for t in ambients] for g in grades], "ambient, degC", caption)


def _said(o: cold.Outcome) -> str:
    """A start in one line, for who rests the pointer on its cell."""
    return (
        f"{o.case.grade}, {o.case.ambient:g} degC: {o.verdict}; {o.viscosity:.0f} mm2/s; allowed at the start {100 * o.first_raise:.0f} "
        "% up, "
        f"{100 * o.first_lower:.0f} % down; tank {o.tank_oil:.0f}, winding {o.winding:.0f}, at most {o.winding_peak:.0f} degC"
    )


def _verdict_map(outcomes: Sequence[cold.Outcome]) -> doc.Html:
    return _map(outcomes, lambda o: Cell(FILLS[o.verdict], label(o), _said(o), o.verdict), "What happens")


def _number_map(outcomes: Sequence[cold.Outcome], name: str, caption: str) -> doc.Html:
    steady = [getattr(o, name) for o in outcomes if not tripped(o)]
    low, high = (min(steady), max(steady)) if steady else (0.0, 1.0)

    def cell(o: cold.Outcome) -> Cell:
        value = getattr(o, name)
        if tripped(o):
            return Cell("#ffffff", "trips", _said(o), o.verdict)
        return Cell(on_scale(value, low, high), number(value, 0), _said(o), o.verdict)

    return _map(outcomes, cell, caption)


def tripped(o: cold.Outcome) -> bool:
    """Whether the run ended because the winding was beyond what the drive bears."""
    return o.winding_peak + ZERO_CELSIUS >= CUT_BACK_FROM


def _table(outcomes: Sequence[cold.Outcome]) -> doc.Html:
    columns = [
        doc.Column("Duty", number=False), doc.Column("Oil", number=False), doc.Column("Ambient", "degC"),
        doc.Column("Viscosity", "mm2/s at the start"),
        doc.Column("Verdict", number=False), doc.Column("Allowed up", "% at the start"), doc.Column("Allowed down", "% at the start"),
        doc.Column("Limit", "at the start", number=False), doc.Column("Full speed", "min"), doc.Column("Over limit", "min"),
        doc.Column("Tank oil", "degC, end"), doc.Column("Pump oil", "degC, end"), doc.Column("Winding", "degC, "
            "end"), doc.Column("Winding", "degC, highest"),
    ]
    rows = [
        (words(o.case.duty), o.case.grade, number(o.case.ambient, 0), number(o.viscosity, 0), o.verdict, number(100 * o.first_raise, 1),
         number(100 * o.first_lower, 1), o.first_limit, number(o.time_to_full / 60.0, 1), number(o.time_over_limit / 60.0, 1),
         *(("–",) * 3 if tripped(o) else (number(o.tank_oil, 1), number(o.pump_oil, 1), number(o.winding, 1))), number(o.winding_peak, 1))
        for o in outcomes
    ]
    return doc.Html(f'<div class="whole-words">{doc.table(columns, rows)}</div>')


def row(o: cold.Outcome) -> dict:
    """One start as flat names and numbers; what a tripped run does not have is None."""
    gone = tripped(o)
    return {
        "duty": o.case.duty, "grade": o.case.grade, "ambient_degC": o.case.ambient, "viscosity_start_mm2_per_s": o.viscosity,
        "viscosity_extrapolated": o.extrapolated, "below_pour_point": o.case.ambient < oil_grade(o.case.grade).pour_point,
        "verdict": o.verdict, "allowed_share_raise_start": o.first_raise, "allowed_share_lower_start": o.first_lower,
        "limited_at_start_by": o.first_limit, "allowed_share_end": o.final_share, "limited_at_end_by": o.final_limit,
        "time_to_full_speed_s": _or_none(o.time_to_full), "time_to_winding_limit_s": _or_none(o.time_over_limit),
        "tank_oil_end_degC": None if gone else o.tank_oil, "pump_oil_end_degC": None if gone else o.pump_oil,
        "winding_end_degC": None if gone else o.winding, "winding_highest_degC": o.winding_peak,
        "tripped": gone, "settled": o.settled and not gone, "cavitating_share_of_cycle": o.cavitating, "simulated_s": float(o.time[-1]),
    }


def _or_none(value: float) -> float | None:
    return None if math.isnan(value) else value


def as_json(rig: Rig, outcomes: Sequence[cold.Outcome], hours: float, seconds: float) -> dict:
    """The machine-readable twin of the page."""
    return {
        "report": "cold_start", "verdict": verdict(outcomes), "rows": [row(o) for o in outcomes],
        "flips": [{"duty": a, "grade": b, "what_happens": c} for a, b, c in flips(outcomes)],
        "end_matter": cold_start_end(rig, outcomes, hours, seconds).as_json() | {
            "rig_id": rig.rig_id, "hours": hours, "computing_time_s": seconds},
    }


def as_csv(outcomes: Sequence[cold.Outcome]) -> str:
    """The rows as comma-separated values with a heading; None is empty."""
    rows = [row(o) for o in outcomes]
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return out.getvalue()
