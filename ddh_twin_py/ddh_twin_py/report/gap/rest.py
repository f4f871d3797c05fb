"""What is left of a gap: signals before and after, whether the rest is noise, and what no listed effect explains."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.gap.contract import Shrunk
from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.gap.findings import Shape, Trace
from ddh_twin_py.report.gap.words import NEAR, axis_scale, capital, component_name, signal_name, times_floor
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.curve_plot import Curve, curve_plot
from ddh_twin_py.report.units import in_unit, number, plus_minus, shown

PERSISTENT = 0.5
"""Persistence from which on a residual shows a pattern."""
_FEWEST = 5  # pairs of samples
_MANY = 16  # pairs of samples from which on chance alone stays below `PERSISTENT`, by two standard deviations
_FOLLOWS = 0.25  # share of a residual's variance that follows a variable, from which it is no scatter
_PARTS = 10  # of equal count along the variable


def persistence(residual: np.ndarray) -> float:
    """How far samples keep their sign, to the next or, as strokes to either side alternate, to the next but one: 0 is noise, 1 a smooth
    curve or an offset; NaN where fewer than 5 samples follow each other so.

    Args:
        residual: (n,), NaN where missing.
    """
    found = [_kept(residual[:-lag], residual[lag:]) for lag in (1, 2)]
    return max((one for one in found if not np.isnan(one)), default=float("nan"))


def _kept(first: np.ndarray, second: np.ndarray) -> float:
    """Mean product of pairs of samples, (n,) each, over their power; NaN where fewer than 5 are known."""
    both = np.isfinite(first) & np.isfinite(second)
    if np.count_nonzero(both) < _FEWEST:
        return float("nan")
    power = float(np.sqrt(np.mean(first[both] ** 2) * np.mean(second[both] ** 2)))
    return float(np.mean(first[both] * second[both])) / power if power > 0.0 else float("nan")


def followed(residual: np.ndarray, variable: np.ndarray) -> float:
    """Share of a residual's variance that follows a variable, by the means of parts of equal count (omega squared); 0 is chance.

    Args:
        residual, variable: (n,), NaN where missing.

    Returns:
        NaN where fewer than 5 samples fall into a part.
    """
    known = np.isfinite(residual) & np.isfinite(variable)
    y, x = residual[known], variable[known]
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, _PARTS + 1))) if x.size else np.zeros(0)
    if edges.size < 3 or y.size < _FEWEST * edges.size or np.ptp(y) == 0.0:
        return float("nan")
    part = np.clip(np.searchsorted(edges, x, "right") - 1, 0, edges.size - 2)
    count = np.bincount(part, minlength=edges.size - 1)
    mean = np.divide(np.bincount(part, y, edges.size - 1), count, out=np.zeros(edges.size - 1), where=count > 0)
    between, whole = float(np.sum(count * (mean - y.mean()) ** 2)), float(np.sum((y - y.mean()) ** 2))
    chance = (whole - between) / (y.size - count.size)
    return max(0.0, (between - (count.size - 1) * chance) / (whole + chance))


def judged(times: float, trace: Trace | None, axes: Mapping[str, tuple[np.ndarray, np.ndarray]] | None = None) -> doc.Html:
    """Whether what is left of a signal is noise, as a mark with words.

    Args:
        times: RMS of what is left in multiples of the floor. trace: None where there is none. axes: variables that it may follow, name with
            unit to times (m,) and values (m,).
    """
    if times <= NEAR:
        return doc.mark("good", "noise")
    level = "fair" if times <= 2.0 else "poor"
    residual = np.zeros(0) if trace is None else trace.measured - trace.after
    pattern, pairs = persistence(residual), int(np.count_nonzero(np.isfinite(residual[:-1]) & np.isfinite(residual[1:])))
    if pattern > max(PERSISTENT, 2.0 / np.sqrt(max(pairs, 1))):
        return doc.mark(level, "a pattern remains")
    along = {} if trace is None else {name: followed(residual, np.interp(trace.time, *course)) for name, course in (axes or {}).items()}
    most = max(along, key=lambda name: np.nan_to_num(along[name]), default="")
    if most and along[most] > _FOLLOWS:
        return doc.mark(level, f"follows {_variable(most)}")
    return doc.mark(level, "scatter beyond the noise" if pairs >= _MANY else "more than noise")  # of few samples chance may be either


def shrink_table(diagnosis: Diagnosis) -> doc.Html:
    """Per signal the RMS of what the twin misses, before and after, in people's units and in multiples of the floor."""
    shrink = diagnosis.report["shrink"]
    if not shrink:
        return doc.paragraph("No signal could be compared.")
    columns = (
        doc.Column("Signal", number=False), doc.Column("Before", "RMS (95 %)"), doc.Column("After", "RMS (95 %)"),
        doc.Column("Noise floor", "RMS"),
        doc.Column("Before", "× floor"), doc.Column("After", "× floor"), doc.Column("What is left", number=False),
    )
    rows = []
    for name, row in sorted(shrink.items(), key=lambda item: -times_floor(item[1], "before")):
        before, after = times_floor(row, "before"), times_floor(row, "after")
        rows.append((capital(signal_name(name)), _with_interval(row, "before"), _with_interval(row, "after"),
                     in_unit(row["noise"], row["unit"]), number(before, 2), number(after, 2),
                     judged(after, diagnosis.traces.get(name), diagnosis.axes)))
    return doc.Html(doc.table(columns, rows) + doc.note(
        "RMS: the usual size of the difference between measured and twin (root of the mean square), on data that took no part in finding "
        "or fitting; in brackets where it lies with 95 %, by stretches of up to 30 s drawn again and again. "
        f"Up to {NEAR:g} times the floor nothing is left but noise. A pattern is a difference that keeps its sign from one "
        "sample to the next (of strokes, to the next in the same direction), a constant one included; scatter does not. What follows a "
        "variable has a quarter of its variance or more in its means over that variable."))


def _with_interval(row: Shrunk, when: str) -> str:
    """RMS in people's unit with its 95 % interval where there is one."""
    written = in_unit(row[when], row["unit"])
    ends = [in_unit(end, row["unit"], False) for end in row.get(f"{when}_interval") or ()]
    return f"{written} ({'–'.join(ends)})" if ends else written


def unknown(diagnosis: Diagnosis) -> doc.Html:
    """What no listed effect explains: where, how large, on what it depends, drawn; empty where there is nothing."""
    found = diagnosis.report["unknown"]
    if not found:
        return doc.Html("")
    depends = ", ".join(_variable(name) for name in found["depends_on"])
    hangs = " It changes with none of the variables that were looked at."
    if depends:
        hangs = f" It changes with {depends}" + (", strongest first." if len(found["depends_on"]) > 1 else ".")
    large = f"about {plus_minus(found['size'], None, found['unit'])}" if found["size"] else "something"
    words = f"{capital(component_name(found['component']))}, {found['domain']}: {large} that no effect of the catalogue explains.{hangs}"
    return doc.Html(doc.paragraph(words) + shapes(diagnosis.shapes))


def shapes(several: list[Shape]) -> doc.Html:
    """Curves of what is left over the variables that it depends on, with two standard deviations."""
    plots = []
    for shape in several:
        unit = shown(shape.unit)
        name, axis_unit, factor, shift = axis_scale(shape.variable, float(np.nanmin(shape.at)) if shape.at.size else 0.0)
        value, spread = shape.value * unit.factor, 2.0 * shape.std * unit.factor
        curve = Curve("left", "fused", (shape.at - shift) * factor, value, value - spread, value + spread)
        said = f"measured − twin, {signal_name(shape.signal)}, {unit.unit}" if shape.signal else f"measured − twin, {unit.unit}"
        plots.append(curve_plot([curve], f"{name}, {axis_unit}" if axis_unit else name, said, width=460, height=240))
    if not any(plots):
        return doc.Html("")
    note = doc.note("Line: measured less twin of one signal beside the best listed hypothesis, the rig's parameters fitted anew, so "
                    "less than what acts at the place as a whole. Band: two standard deviations of the mean.")
    return doc.Html(f'<div class="plots large">{"".join(plots)}</div>{note}')


def _variable(name: str) -> str:
    return axis_scale(name, float("nan"))[0]
