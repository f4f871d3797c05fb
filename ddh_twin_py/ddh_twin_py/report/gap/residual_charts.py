"""What the twin misses of each signal, before and after the leading hypothesis: against time and against other variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import STROKE
from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.gap.findings import Trace
from ddh_twin_py.report.gap.words import NEAR, axis_scale, capital, signal_name, times_floor
from ddh_twin_py.report.page import charts
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.curve_plot import Curve, curve_plot
from ddh_twin_py.report.times import going_on
from ddh_twin_py.report.units import ZERO_CELSIUS, number, shown

BINS = 16
"""Classes of a variable, of equal width between its 1st and 99th percentile."""
LEAST = 6
"""Samples that a class needs to be drawn."""
GAP = 6.0
"""Usual steps of time above which data were left out between two samples."""
_MOST_POINTS = 6000
_MOST_BINNED = 20_000
"""Samples that are sorted into classes: every second, third or so of a longer trace."""
_LEAST_SPAN = 0.02
"""Share of a variable's own span that the samples of a signal must cover for its residual to be drawn against it."""
_STROKE = ("Drawn is the rod's position at rest, at the end of each stroke. The twin begins every stroke where the rig did, so the "
           "difference is the error of that stroke alone.")
_OPEN = 4
"""Signals drawn unfolded, those that are furthest off before."""


@dataclass(frozen=True)
class Binned:
    """Residuals sorted by a variable: per class its middle, the median and the 16th and 84th percentile; samples used."""

    at: np.ndarray
    median: np.ndarray
    low: np.ndarray
    high: np.ndarray
    samples: int


def binned(variable: np.ndarray, residual: np.ndarray, bins: int = BINS, least: int = LEAST) -> Binned:
    """Median and middle two thirds of the residual in classes of a variable.

    Args:
        variable, residual: (n,); NaN counts for nothing. least: samples that a class needs.
    """
    used = np.isfinite(variable) & np.isfinite(residual)
    x, y = variable[used], residual[used]
    if x.size < least:
        return Binned(*(np.zeros(0) for _ in range(4)), 0)
    first, last = np.percentile(x, (1.0, 99.0))
    if not last > first:
        first, last = float(x.min()), float(x.max())
    span = (last - first) or 1.0
    place = np.clip(((x - first) / span * bins).astype(int), 0, bins - 1)
    order = np.argsort(place, kind="stable")
    ends = np.searchsorted(place[order], np.arange(bins + 1))
    rows = [
        (np.median(x[order[a:b]]), *np.percentile(y[order[a:b]], (50.0, 16.0, 84.0)))
        for a, b in zip(ends[:-1], ends[1:], strict=True) if b - a >= least
    ]
    columns = np.array(rows).T if rows else np.zeros((4, 0))
    return Binned(*columns, int(x.size))


def broken(time: np.ndarray, series: Sequence[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Time that always rises and series with a missing sample wherever data were left out, so that no line crosses the gap.

    Args:
        time: s, (n,). series: arrays (n,). A gap is a step of more than `GAP` usual ones.
    """
    time = going_on(time)
    step = np.diff(time)
    if not step.size:
        return time, list(series)
    wide = np.flatnonzero(step > GAP * np.median(step))
    middle = 0.5 * (time[wide] + time[wide + 1])
    return np.insert(time, wide + 1, middle), [np.insert(np.asarray(s, dtype=float), wide + 1, np.nan) for s in series]


def along(trace: Trace, axis: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """A variable at the times of a trace, NaN outside of its own span; NaN alone where its own times do not rise."""
    time, values = axis
    if time.size == trace.time.size and np.array_equal(time, trace.time):
        return np.asarray(values, dtype=float)
    keep = np.isfinite(values)
    if not keep.any() or (np.diff(time[keep]) <= 0.0).any():
        return np.full(trace.time.size, np.nan)
    return np.interp(trace.time, time[keep], np.asarray(values, dtype=float)[keep], left=np.nan, right=np.nan)


def varies(at: np.ndarray, values: np.ndarray) -> bool:
    """Whether a variable says anything of a signal: its span over the signal's samples (n,) against its own (m,). Strokes are
    measured at rest, where speed is none."""
    own = np.ptp(values[np.isfinite(values)])
    return bool(np.subtract(*np.percentile(at, (99.0, 1.0))) > _LEAST_SPAN * own)


def residual_sections(diagnosis: Diagnosis) -> list[doc.Html]:
    """One block per signal, the furthest off first; the leading few open, the others folded."""
    order = sorted(diagnosis.traces, key=lambda name: -_times(diagnosis, name, "before"))
    far = [n for n in order if _times(diagnosis, n, "before") > NEAR or _times(diagnosis, n, "after") > NEAR]
    shown_open = far[:_OPEN] or order[:1]
    spans = [t.time for t in diagnosis.traces.values() if t.time.size]
    domain = (min(float(t[0]) for t in spans), max(float(going_on(t)[-1]) for t in spans)) if spans else (0.0, 1.0)
    blocks = []
    for name in order:
        block = _signal(name, diagnosis.traces[name], diagnosis.axes, domain)
        if not block:
            continue
        title = f"{capital(signal_name(name))}: {_said(diagnosis, name)}"
        if name in shown_open:
            blocks.append(doc.Html(f"<h3>{doc.text(title)}</h3>{block}"))
        else:
            blocks.append(doc.details(title, block))
    return blocks


def _times(diagnosis: Diagnosis, name: str, when: str) -> float:
    row = diagnosis.report["shrink"].get(name)
    if row is not None:
        return times_floor(row, when)
    trace = diagnosis.traces[name]
    off = trace.measured - getattr(trace, when)
    off = off[np.isfinite(off)]
    return float(np.sqrt(np.mean(off**2))) / trace.floor if off.size else 0.0


def _said(diagnosis: Diagnosis, name: str) -> str:
    return f"{number(_times(diagnosis, name, 'before'), 2)} → {number(_times(diagnosis, name, 'after'), 2)} × floor"


def _signal(name: str, trace: Trace, axes: Mapping, domain: tuple[float, float]) -> doc.Html:
    if not trace.time.size:
        return doc.Html("")
    unit = shown(trace.unit)
    time, (measured, before, after) = broken(trace.time, (trace.measured, trace.before, trace.after))
    shift = ZERO_CELSIUS if trace.unit == "K" else 0.0
    label = "°C" if trace.unit == "K" else unit.unit
    lines = [
        charts.Trace("measured", "measured", (measured - shift) * unit.factor),
        charts.Trace("before", "predicted", (before - shift) * unit.factor),
        charts.Trace("after", "fused", (after - shift) * unit.factor),
    ]
    chart = charts.Chart(
        "Measured and twin", label, time, lines, digits=unit.digits, height=170, wide=True,
        differences=((0, 1), (0, 2)), floor=trace.floor * unit.factor, below=140, most=_MOST_POINTS,
        difference_unit=unit.unit, note=_STROKE if name == STROKE else "",
    )
    return doc.Html(charts.charts([chart], domain) + _against(trace, axes))


def _against(trace: Trace, axes: Mapping) -> str:
    unit = shown(trace.unit)
    every = max(1, -(-trace.time.size // _MOST_BINNED))
    residuals = [(label, role, ((trace.measured - predicted) * unit.factor)[::every])
                 for label, role, predicted in (("before", "predicted", trace.before), ("after", "fused", trace.after))]
    plots = []
    for name, axis in axes.items():
        variable = along(trace, axis)[::every]
        finite = variable[np.isfinite(variable)]
        if not finite.size or not varies(finite, axis[1]):
            continue
        said, axis_unit, factor, shift = axis_scale(name, float(finite.min()))
        curves = []
        for label, role, residual in residuals:
            b = binned((variable - shift) * factor, residual)
            curves.append(Curve(label, role, b.at, b.median, b.low, b.high))
        if curves[0].at.size > 1:
            x_title = f"{said}, {axis_unit}" if axis_unit else said
            plots.append(curve_plot(curves, x_title, f"measured − twin, {unit.unit}", trace.floor * unit.factor))
    return f'<div class="plots">{"".join(plots)}</div>' if plots else ""
