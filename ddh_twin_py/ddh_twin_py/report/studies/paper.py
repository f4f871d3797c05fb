"""The page of `ddh-twin paper`: the table, and pictures that correspond to the paper's figures 3 to 6."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.oil import ZERO_CELSIUS
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, NODES
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.charts import Chart, Trace, charts
from ddh_twin_py.report.studies.paper_rows import COMPUTED, FITTED, INPUT, Row
from ddh_twin_py.report.units import number, words
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.paper_cycle import CYCLES, Reading
from ddh_twin_py.twin.paper_runs import Runs

TITLE = "A Thermal Analysis of Direct Driven Hydraulics"
SURFACES = ("housing", "pump_1_case", "pump_2_case", "cylinder_barrel", "tank_wall", "line_a_wall")


def cell(value: float | str | None) -> str:
    """A number with three or four figures, words as they are, a dash where there is none."""
    if value is None or isinstance(value, str):
        return value or "–"
    return number(value, 1 if abs(value) >= 100.0 else 2 if abs(value) >= 10.0 else 3)


def verdict(rows: list[Row]) -> str:
    """One sentence: how many of the paper's numbers the twin meets within 10 %, those that test it first, by the labels of the table."""
    numbers = [row for row in rows if row.difference is not None]
    near = [row for row in numbers if abs(row.difference) <= 0.1 * abs(row.paper)]
    (met, computed), (met_fitted, fitted), (_, given) = (
        [sum(row.origin == origin for row in several) for several in (near, numbers)] for origin in (COMPUTED, FITTED, INPUT))
    return (
        f"{met or 'None'} of the {computed} numbers that the twin computes {'are' if met > 1 else 'is'} within 10 % of the paper's; of the "
        f"{fitted} that its data sheet was fitted to, which tests nothing, {met_fitted or 'none'} {'are' if met_fitted > 1 else 'is'}; "
        f"{given} more are inputs and not counted; the others, and what the paper states in words, are explained row by row."
    )


def paper_end(rig: Rig) -> doc.EndMatter:
    """What the numbers rest on."""
    return doc.EndMatter(
        "Nothing was fitted here. Where the data sheet took a number from the paper (torque, leakage), the row says so or its "
        "source in the rig file does; such a row is no test of the model.",
        rig.file,
        [
            "Minav, Papini, Pietola: the text of the paper; its figures are pictures without printed values, so that they are "
            "compared in kind and not point by point.",
            f"Free run of the model from everything at ambient, {CYCLES} cycles; the lift stops short of the end stops, rests and "
            "ramps are those of the project's recording of the cycle.",
            "Differences are twin less paper.",
        ],
    )


def paper_json(runs: Runs, table: list[Row]) -> dict:
    """The machine-readable twin of the page."""
    return {
        "report": "paper", "verdict": verdict(table), "rows": [row.as_json() for row in table],
        "end_matter": paper_end(runs.rig).as_json(),
    }


def paper_document(runs: Runs, table: list[Row]) -> doc.Document:
    """The page."""
    page = doc.Document(
        kind="The paper's results", title=TITLE, verdict=verdict(table), level="fair", end=paper_end(runs.rig),
    )
    columns = (
        doc.Column("Result", number=False), doc.Column("Paper"), doc.Column("Twin"), doc.Column("Difference"),
        doc.Column("Unit", number=False), doc.Column("Twin's number", number=False), doc.Column("Explanation", number=False),
    )
    rows = [
        (row.result, cell(row.paper), cell(row.twin), cell(row.difference), row.unit.replace("*", "·"),
         row.origin, row.explanation.replace("N*m", "N·m"))
        for row in table
    ]
    page.add("Paper and twin", _wrapping(doc.table(columns, rows)))
    page.add("Figure 3: motor housing and winding at the equivalent current", *_figure_3(runs))
    page.add("Figure 4: position, oil of pumps and tank", *_figure_4(runs.slow))
    page.add("Figure 5: pressure, height, speed, flow and torque", *_figure_5(runs))
    page.add("Figure 6: temperatures during lifting and lowering", *_figure_6(runs.slow))
    return page


def _wrapping(table: doc.Html) -> doc.Html:
    return doc.Html(table.replace("<table>", '<table class="wrap-first">'))


def _figure_3(r: Runs) -> list[str]:
    shown = r.equivalent_time <= r.slow.time[-1]
    time, degrees = r.equivalent_time[shown], r.equivalent[shown] - ZERO_CELSIUS
    column = MOTOR_NODES.index
    winding, housing = degrees[:, column("end_winding")], degrees[:, column("housing")]
    top = np.full(time.size, float(housing.max()))
    per_cycle = int(round(r.slow.cycle / (r.equivalent_time[1] - r.equivalent_time[0])))
    rows = []
    for k in (1, 2, 5, 10, CYCLES):
        at = r.equivalent[min(k * per_cycle, r.equivalent_time.size) - 1] - r.slow.start
        rows.append((str(k), *(number(at[column(node)], 2) for node in ("end_winding", "slot_winding", "housing"))))
    return [
        doc.paragraph(
            "The paper shows a) the housing and b) the winding's hot spot under the constant equivalent current of its eq. 6, in b) with "
            "the housing's highest temperature as a broken line. Here: the same current over the first cycles; the table goes on."
        ),
        charts([
            Chart("a) Motor housing", "°C", time, [Trace("housing", "predicted", housing)]),
            Chart("b) Winding", "°C", time, [
                Trace("end winding, hot spot", "predicted", winding),
                Trace("slot winding", "c1", degrees[:, column("slot_winding")]),
                Trace("housing, highest", "measured", top, dash=True),
            ]),
        ]),
        doc.table([doc.Column("Cycles"), doc.Column("End winding", "K above start"), doc.Column("Slot winding", "K above start"),
                   doc.Column("Housing", "K above start")], rows),
        doc.note("Where it differs: the winding starts with about the paper's rise per cycle and then bends, as its heat reaches the "
                 "iron; the housing lags and rises far less than the paper's 1 K per cycle, see the table above."),
    ]


def _column(reading: Reading, node: str) -> np.ndarray:
    return reading.temperatures[:, NODES.index(node)] - ZERO_CELSIUS


def _figure_4(slow: Reading) -> list[str]:
    oils = [Trace(words(node), f"c{k}", _column(slow, node)) for k, node in enumerate(("pump_1_oil", "pump_2_oil", "tank_oil"), 1)]
    return [
        doc.paragraph("The paper shows the position and the simulated oil in pump/motors and tank: rising in the lift, flat in lowering."),
        charts([
            Chart("Rod position", "mm", slow.time,
                  [Trace("position", "predicted", slow.points["rod_position"] * 1e3)], height=150, wide=True),
            Chart("Oil", "°C", slow.time, oils, wide=True, height=230),
        ]),
        doc.note("Where it differs: at the reversal pump oil drops, since the pumps hold little oil and other oil runs through "
                 "them, and only then is it flat; the paper names no drop."),
    ]


def _figure_5(r: Runs) -> list[str]:
    slow, fast = r.slow, r.fast
    rpm = 30.0 / np.pi

    def set_of(reading: Reading) -> str:
        p, t = reading.points, reading.time
        return charts([
            Chart(f"Pressure, {reading.name}", "bar", t, [
                Trace("piston side", "c1", p["pressure_piston_side"] * 1e-5), Trace("rod side", "c2", p["pressure_rod_side"] * 1e-5)]),
            Chart(f"Height, {reading.name}", "m", t, [Trace("rod position", "predicted", p["rod_position"])]),
            Chart(f"Speed, {reading.name}", "rpm", t, [Trace("motor", "predicted", p["speed"] * rpm)], digits=0),
            Chart(f"Rod velocity, {reading.name}", "m/s", t, [Trace("rod", "predicted", p["rod_velocity"])], digits=4),
            Chart(f"Flow, {reading.name}", "L/min", t, [
                Trace("pump 1", "c1", p["pump_1_flow"] * 6e4), Trace("pump 2", "c2", p["pump_2_flow"] * 6e4)]),
            Chart(f"Torque, {reading.name}", "N·m", t, [Trace("motor, current by constant", "predicted", p["torque"])]),
        ])

    return [
        doc.paragraph("The paper shows measured pressure, height, speed, flow rate and estimated torque of one cycle. Its text says 500 "
            "rpm "
                      "and 0.2 m/s; both readings are drawn."),
        set_of(slow),
        doc.note("Reading 500 rpm: torque and pressure are near the paper's, the rod moves at "
                 f"{slow.points['rod_velocity'][slow.lift()].mean():.3f} m/s instead of the text's 0.2 m/s."),
        set_of(fast),
        doc.note("Reading 0.2 m/s: the rod is about as fast as the text says; the lift takes up to "
                 f"{fast.points['torque'][fast.lift()].max():.1f} N·m and "
                 f"{fast.points['pressure_piston_side'][fast.lift()].max() * 1e-5:.0f} bar at the piston side."),
    ]


def _figure_6(slow: Reading) -> list[str]:
    traces = [Trace(words(node), f"c{k}", _column(slow, node)) for k, node in enumerate(SURFACES, 1)]
    shown = (*SURFACES, "pump_1_oil", "pump_2_oil", "tank_oil", "end_winding")
    rows = [
        (words(node), *(number(slow.ends[k - 1, NODES.index(node)] - ZERO_CELSIUS, 2) for k in (1, 2, 5, 10, CYCLES))) for node in shown
    ]
    return [
        doc.paragraph("The paper shows measured temperatures during lifting and lowering. Here: the surfaces of the model over the first "
                      f"cycles, and a table over {CYCLES} cycles with oil and winding beside them."),
        charts([Chart("Surfaces, first cycles", "°C", slow.time, traces, wide=True, height=230)]),
        doc.table([doc.Column("Node", number=False), *(doc.Column(f"Cycle {k}", "°C, end") for k in (1, 2, 5, 10, CYCLES))], rows),
        doc.note("Where it differs: a real setup starts warm from the runs before, the model from ambient; the winding leads, the "
            "surfaces of tank, "
                 "lines and barrel follow the oil from below."),
    ]
