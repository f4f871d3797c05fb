"""Interactive time-series charts of a report: data packed for the page, drawn by uPlot.

All charts of a page share zoom, pan and cursor. `assets/charts.js` is the other half.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from ddh_twin_py.report.page.decimate import MOST_POINTS, decimated

ROLES = ("measured", "predicted", "fused", "soft", *(f"c{n}" for n in range(1, 9)))
"""Colours of the style sheet (`--s-<role>`): what was measured, the free run, the fused estimate, the soft
sensor, and eight components."""

_STEPS = 65534


@dataclass(frozen=True)
class Trace:
    """One line of a chart.

    Args:
        label: in the legend. role: one of `ROLES`.
        values: (n,), in the unit of the chart; NaN is a gap.
        dots: draw samples and no line. dash: draw a broken line. shown: drawn before anyone clicks.
        spread: (n,), half height of a band around the values, or None.
        ends: lowest and highest of what each value is the mean of, (n,) each, drawn as a band in place of `spread`; or None.
    """

    label: str
    role: str
    values: np.ndarray
    dots: bool = False
    dash: bool = False
    shown: bool = True
    spread: np.ndarray | None = None
    ends: tuple[np.ndarray, np.ndarray] | None = None


@dataclass(frozen=True)
class Chart:
    """Lines over one time axis.

    Args:
        title: what is drawn. unit: of the values. time: s, (n,), increasing.
        digits: decimals of a value under the cursor. height: pixels. wide: over the whole page.
        zero: the axis holds zero. note: one sentence below.
        unsettled: spans (from, to), s, in which the bands are drawn but do not stretch the axis.
        differences: pairs (line, reference) of trace numbers, drawn below as line minus
            reference, with a band of plus and minus ``floor``. below: height of that part, pixels.
        difference_unit: named beside the chart's; empty where it need not be said.
    """

    title: str
    unit: str
    time: np.ndarray
    traces: Sequence[Trace]
    digits: int = 2
    height: int = 200
    wide: bool = False
    zero: bool = False
    note: str = ""
    differences: Sequence[tuple[int, int]] = ()
    floor: float = 0.0
    unsettled: Sequence[tuple[float, float]] = ()
    below: int = 92
    difference_unit: str = ""
    most: int = field(default=MOST_POINTS)

    def html(self, domain: tuple[float, float]) -> str:
        """A figure; ``domain`` is the time span of the page, s."""
        arrays, lines = [], []
        differences = [self.traces[a].values - self.traces[b].values for a, b in self.differences]
        for trace in self.traces:
            if trace.role not in ROLES:
                raise ValueError(f"no colour for {trace.role!r}; valid are {', '.join(ROLES)}")
            line = {"label": trace.label, "role": trace.role}
            for name in ("dots", "dash"):
                if getattr(trace, name):
                    line[name] = True
            if not trace.shown:
                line["hidden"] = True
            lines.append(line)
            arrays.append(np.asarray(trace.values, dtype=float))
            if trace.spread is not None:
                line["band"] = True
                arrays += [trace.values + trace.spread, trace.values - trace.spread]
            elif trace.ends is not None:
                line["band"] = line["ends"] = True
                arrays += [trace.ends[1], trace.ends[0]]
        count = len(arrays)
        time, arrays = decimated(np.asarray(self.time, dtype=float), [*arrays, *differences], self.most)
        spec = {
            "title": self.title, "unit": self.unit, "digits": self.digits, "height": self.height, "zero": self.zero,
            "domain": [round(float(edge), 3) for edge in domain],
            "lines": lines, "x": float32(time), "y": [quantised(values) for values in arrays[:count]],
        }
        if self.unsettled:
            spec["unsettled"] = [[float(edge) for edge in span] for span in self.unsettled]
        if differences:
            spec |= {"differences": [list(pair) for pair in self.differences], "floor": self.floor, "below": self.below}
        unit = f"{self.unit}; below: their difference, {self.difference_unit}" if self.difference_unit else self.unit
        note = f'<p class="note">{escape(self.note)}</p>' if self.note else ""
        return (
            f'<figure class="chart{" wide" if self.wide else ""}"><figcaption>{escape(self.title)}'
            f' <span class="unit">{escape(unit)}</span></figcaption>'
            f'<div class="plot" tabindex="0" role="img" style="min-height:{self.height}px"'
            f' aria-label="{escape(self.title)} over time, in {escape(self.unit)}"></div>'
            f'{note}<script type="application/json">{script_json(spec)}</script></figure>'
        )


def charts(several: Sequence[Chart], domain: tuple[float, float] | None = None) -> str:
    """A grid of charts that share one time span, s; where none is given, the widest of their own."""
    several = [chart for chart in several if chart.time.size]
    if not several:
        return ""
    if domain is None:
        domain = (min(float(c.time[0]) for c in several), max(float(c.time[-1]) for c in several))
    return '<div class="charts">' + "".join(chart.html(domain) for chart in several) + "</div>"


def float32(values: np.ndarray) -> str:
    """Little-endian float32 in base64."""
    return _base64(np.asarray(values, dtype="<f4"))


def quantised(values: np.ndarray) -> list:
    """Lowest and highest value and, in base64, each value's place between them in 65,534 steps.

    The extremes are kept as they are; 65535 stands for NaN.
    """
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    place = np.rint((values - low) / ((high - low) or 1.0) * _STEPS)
    return [low, high, _base64(np.where(np.isfinite(values), place, _STEPS + 1).astype("<u2"))]


def _base64(array: np.ndarray) -> str:
    return base64.b64encode(array.tobytes()).decode("ascii")


def script_json(data: object) -> str:
    """JSON that cannot end the script element around it."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
