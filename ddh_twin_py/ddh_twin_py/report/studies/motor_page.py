"""The page and the terminal table of `ddh-twin motor`."""

from __future__ import annotations

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ddh_twin_py.physics.equivalent_current import Comparison
from ddh_twin_py.physics.motor import RAD_PER_S_OF_RPM
from ddh_twin_py.physics.motor_condensed import Condensed
from ddh_twin_py.physics.motor_geometry import ZERO_CELSIUS, Network
from ddh_twin_py.report.page.document import Column, Document, EndMatter, Figure, Html, figures, mark, note, paragraph, table
from ddh_twin_py.report.studies.motor_comparison import Row, Sensitivity, Step, observed_order, out_of_range, rated_load
from ddh_twin_py.report.studies.slot_picture import slot_picture

_LEVEL = {"within one": "good", "within the sheet's range": "fair", "outside": "poor"}
_SILENT = "The description gives no explanation."
_STYLE = {"good": "green", "fair": "yellow", "poor": "red"}


def verdict(table_rows: Sequence[Row]) -> str:
    """How many quantities lie where, in a sentence."""
    outside = [row for row in table_rows if row.verdict == "outside"]
    inside = sum(row.verdict == "within one" for row in table_rows)
    explained = sum(bool(row.note) for row in outside)
    said = f"Of {len(table_rows)} quantities {inside} are within one standard deviation of the sheet, "
    said += f"{len(table_rows) - inside - len(outside)} more within its range of 2.5, {len(outside)} outside"
    return said + (f" ({explained} of them explained)." if outside else ".")


def motor_end(network: Network) -> EndMatter:
    """What the numbers rest on."""
    m = network.machine
    return EndMatter(
        "none: nothing was fitted; every value follows from the description", network.rig.file,
        [
            f"{path}: {entry.value:g}{_space(entry.unit)} – {entry.source}"
            for path, entry in m.entries.items() if "assumption" in entry.source
        ],
        [("Description", m.file), ("Mesh", f"{network.mesh_layers} layers, {network.size} nodes")],
    )


def motor_document(
    network: Network, condensed: Condensed, rows: Sequence[Row], steps: Sequence[Step], sensitive: Sequence[Sensitivity],
    runs: Sequence[Comparison],
) -> Document:
    """The report of a generated motor."""
    m, rig = network.machine, network.rig
    load = rated_load(m, rig)
    temperature = network.steady(load)
    means, hot = network.means(temperature), network.hot_spot(temperature)
    outside = any(row.verdict == "outside" for row in rows)
    level = "poor" if any(row.verdict == "outside" and not row.note for row in rows) else "fair" if outside else "good"
    page = Document("Motor from its geometry", m.machine_id, verdict(rows), motor_end(network), level)
    page.add(
        "Steady state at rated current",
        figures([
            Figure("hot spot of the slot", _degC(hot), f"{hot - means['slot_winding']:.1f} K above the slot's mean"),
            Figure("end winding", _degC(means["end_winding"]), "mean"),
            Figure("housing", _degC(means["housing"]), f"ambient {_degC(load.ambient)}"),
            Figure(
                "heat", f"{network.made(temperature, load):.0f} W",
                f"{load.current:.2f} A rms, {load.speed / RAD_PER_S_OF_RPM:.0f} rpm",
            ),
        ]),
        slot_picture(network, temperature),
        note(
            "One slot pitch in the middle of the stack, bore below, housing above. Half of it is the mesh, the other half its "
            "mirror image; the liner is white."
        ),
    )
    page.add("Generated and data sheet", _quantities(rows), note(
        "Deviation in standard deviations of the sheet; its values are cut at 2.5. With these conductances the sheet's network "
        f"answers heat in any lump like the fine one within {100.0 * condensed.misfit:.1f} %."
    ))
    page.add("Where and why they differ", _long(table([Column("quantity", number=False), Column("in σ"), Column("why", number=False)], [
        (row.path, _deviation(row), row.note or _SILENT) for row in rows if row.verdict != "within one"
    ])))
    page.add("Mesh", _mesh(steps))
    if sensitive:
        page.add("What the assumptions weigh", _sensitive(sensitive), note("Changes of generated quantities above 3 %."))
    if runs:
        page.add("Equivalent current (equation 6)", _runs(runs), note(
            "Cosine current whose equivalent is the rated current, run until it repeats itself. Excess: largest mean slot "
            "temperature of the cycle above the steady state with the equivalent current. Cycles that are short against the "
            "winding's time constant are met; long ones are not, and their mean loss grows, since resistance is highest when "
            "the current is."
        ))
    leaves = out_of_range(network)
    inside = "All within their published ranges up to the rig's maximum speed."
    page.add("Range of the correlations", paragraph("; ".join(leaves) + "." if leaves else inside))
    return page


def print_motor(network: Network, condensed: Condensed, rows: Sequence[Row], steps: Sequence[Step], console: Console) -> None:
    """The table on the terminal."""
    shown = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, padding=(0, 1, 0, 0))
    shown.add_column("quantity", no_wrap=True)
    for name in ("generated", "sheet", "± 1σ", "deviation", "unit"):
        shown.add_column(name, justify="right" if name != "unit" else "left", no_wrap=True)
    for row in rows:
        style = _STYLE[_LEVEL[row.verdict]]
        shown.add_row(
            _short(row.path), f"{row.generated:.4g}", f"{row.sheet:.4g}", f"{100 * row.tolerance:.0f} %",
            Text(_deviation(row), style=style), _unit(row.unit),
        )
    console.print(Text.assemble((network.machine.machine_id, "bold"), f": {verdict(rows)}"), shown)
    for row in rows:
        if row.verdict == "outside":
            console.print(Text.assemble((row.path, "bold"), f": {row.note or _SILENT}"))
    if steps:
        told = ", ".join(f"{s.layers} layers {s.slot_over_teeth:.2f} K" for s in steps)
        order = f"; order of convergence {observed_order(steps):.1f}" if len(steps) > 2 else ""
        console.print(f"Mesh, slot above teeth at rated current: {told}{order}")
    console.print(f"Sheet's network against the fine one: {100 * condensed.misfit:.1f} % at most")


def _quantities(rows: Sequence[Row]):
    columns = [
        Column("quantity", number=False), Column("generated"), Column("sheet"), Column("tolerance", "1 σ"),
        Column("deviation", "in σ"), Column("unit", number=False), Column("verdict", number=False),
    ]
    return table(columns, [
        (row.path, f"{row.generated:.4g}", f"{row.sheet:.4g}", f"{100 * row.tolerance:.0f} %", _deviation(row), _unit(row.unit),
         mark(_LEVEL[row.verdict], row.verdict)) for row in rows
    ])


def _mesh(steps: Sequence[Step]) -> str:
    columns = [
        Column("layers"), Column("nodes"), Column("hot spot", "degC"), Column("slot, mean", "degC"),
        Column("slot above teeth", "K"), Column("slot to teeth", "W/K"),
    ]
    order = f"Order of convergence from the last three: {observed_order(steps):.1f}." if len(steps) > 2 else ""
    return table(columns, [
        (s.layers, s.nodes, f"{s.hot_spot - ZERO_CELSIUS:.2f}", f"{s.slot - ZERO_CELSIUS:.2f}", f"{s.slot_over_teeth:.3f}",
         f"{s.slot_to_teeth:.3f}")
        for s in steps
    ], "At rated current") + note(order)


def _sensitive(sensitive: Sequence[Sensitivity]) -> str:
    columns = [Column("assumption", number=False), Column("values", number=False), Column("changes", number=False)]
    return _long(table(columns, [
        (s.meaning, ", ".join(f"{path} {value:g}" for path, value in s.values.items()),
         ", ".join(f"{_short(path)} {change:+.0%}" for path, change in s.changes.items()) or "none")
        for s in sensitive
    ]))


def _long(made: str) -> Html:
    """A table whose last column holds sentences: it is wide enough for them, and no word is broken."""
    return Html(f'<div class="wrap-first">{made}</div>')


def _runs(runs: Sequence[Comparison]) -> str:
    columns = [
        Column("period", "s"), Column("equivalent", "degC"), Column("cycle's mean", "degC"), Column("cycle's largest", "degC"),
        Column("excess", "K"), Column("mean copper loss", "against equivalent"),
    ]
    return table(columns, [
        (f"{c.period:g}", f"{c.steady - ZERO_CELSIUS:.2f}", f"{c.mean - ZERO_CELSIUS:.2f}", f"{c.largest - ZERO_CELSIUS:.2f}",
         f"{c.largest - c.steady:.2f}", f"{100.0 * (c.mean_loss / c.steady_loss - 1.0):z.2f} %") for c in runs
    ])


def _short(path: str) -> str:
    return path.removeprefix("motor.").removeprefix("thermal.")


def _deviation(row: Row) -> str:
    return "–" if row.deviations is None else f"{row.deviations:+.1f}"


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit


def _space(unit: str) -> str:
    return f" {_unit(unit)}" if _unit(unit) else ""


def _degC(kelvin: float) -> str:
    return f"{kelvin - ZERO_CELSIUS:.1f} °C"
