"""A small plot over any variable as inline SVG: curves with bands, a floor around zero, axes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.report.page.document import Html, text

_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 10.0, 20.0, 34.0
_PER_TICK = 32.0, 58.0  # pixels down and along


@dataclass(frozen=True)
class Curve:
    """A line with a band.

    Args:
        label: in the text for screen readers. role: one of `charts.ROLES`.
        at, value, low, high: (k,), in the units of the axes; NaN points are left out.
        band: whether low to high is filled.
    """

    label: str
    role: str
    at: np.ndarray
    value: np.ndarray
    low: np.ndarray
    high: np.ndarray
    band: bool = True


def curve_plot(curves: Sequence[Curve], x_title: str, y_title: str, floor: float = 0.0, width: int = 300, height: int = 180) -> Html:
    """The plot, zero line included; nothing where no curve has a point.

    Args:
        x_title, y_title: names with units. floor: half height of the grey band around zero.
    """
    kept = [_finite(curve) for curve in curves]
    kept = [curve for curve in kept if curve.at.size]
    if not kept:
        return Html("")
    x_low, x_high = (f(f(c.at) for c in kept) for f in (min, max))
    ends = [e for c in kept for e in ((c.low.min(), c.high.max()) if c.band else (c.value.min(), c.value.max()))]
    y_low, y_high = min(0.0, -floor, *ends), max(0.0, floor, *ends)
    room = 0.05 * ((y_high - y_low) or 1.0)
    y_low, y_high = y_low - room, y_high + room
    if x_high == x_low:
        x_low, x_high = x_low - 0.5, x_high + 0.5

    def px(x):
        return _LEFT + (x - x_low) / (x_high - x_low) * (width - _LEFT - _RIGHT)

    def py(y):
        return _TOP + (y_high - y) / (y_high - y_low) * (height - _TOP - _BOTTOM)

    parts = [f'<text x="4" y="11">{text(y_title)}</text>']
    if floor > 0.0:
        parts.append(f'<rect class="floor" x="{_LEFT:.0f}" y="{py(floor):.1f}" width="{width - _LEFT - _RIGHT:.0f}" '
                     f'height="{py(-floor) - py(floor):.1f}"/>')
    for value in ticks(y_low, y_high, (height - _TOP - _BOTTOM) / _PER_TICK[0]):
        parts.append(f'<path class="grid" d="M{_LEFT:.0f} {py(value):.1f}H{width - _RIGHT:.0f}"/>'
                     f'<text x="{_LEFT - 5:.0f}" y="{py(value) + 4:.1f}" text-anchor="end">{written(value)}</text>')
    for value in ticks(x_low, x_high, (width - _LEFT - _RIGHT) / _PER_TICK[1]):
        parts.append(f'<text x="{px(value):.1f}" y="{height - _BOTTOM + 14:.0f}" text-anchor="middle">{written(value)}</text>')
    parts.append(f'<path class="zero" d="M{_LEFT:.0f} {py(0.0):.1f}H{width - _RIGHT:.0f}"/>')
    for curve in kept:
        if curve.band and curve.at.size > 1:
            edge = [*zip(curve.at, curve.high, strict=True), *zip(curve.at[::-1], curve.low[::-1], strict=True)]
            parts.append(f'<path d="{_path(edge, px, py)}Z" style="fill:var(--s-{curve.role}-band)"/>')
    for curve in kept:
        points = [*zip(curve.at, curve.value, strict=True)]
        parts.append(f'<path d="{_path(points, px, py)}" class="curve" style="stroke:var(--s-{curve.role})"/>')
        parts += [f'<circle cx="{px(x):.1f}" cy="{py(y):.1f}" r="2.2" style="fill:var(--s-{curve.role})"/>' for x, y in points]
    middle = 0.5 * (_LEFT + width - _RIGHT)
    parts.append(f'<text x="{middle:.0f}" y="{height - 4}" text-anchor="middle">{text(x_title)}</text>')
    said = f"{y_title} against {x_title}: " + ", ".join(c.label for c in kept)
    return Html(f'<svg class="curves" viewBox="0 0 {width} {height}" role="img" aria-label="{text(said)}">{"".join(parts)}</svg>')


def ticks(low: float, high: float, about: float) -> list[float]:
    """Round values between low and high, roughly that many and at least two."""
    span = high - low
    if not span > 0.0 or not math.isfinite(span):
        return [low]
    raw = span / about
    ten = 10.0 ** math.floor(math.log10(raw))
    steps = [ten * f for f in (0.2, 0.5, 1.0, 2.0, 5.0, 10.0)]
    place = next(i for i, step in enumerate(steps) if step >= 0.999 * raw)
    for step in steps[place::-1]:
        found = [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]
        if len(found) >= 2:
            break
    return found


def written(value: float) -> str:
    """A tick in as few characters as it needs."""
    said = f"{value:.4g}" if abs(value) < 1e4 else f"{value:.3g}"
    return "0" if float(said) == 0.0 else said.replace("-", "−").replace("e+0", "e")


def _path(points: Sequence[tuple[float, float]], px, py) -> str:
    return "M" + "L".join(f"{px(x):.1f} {py(y):.1f}" for x, y in points)


def _finite(curve: Curve) -> Curve:
    keep = np.isfinite(curve.at) & np.isfinite(curve.value) & np.isfinite(curve.low) & np.isfinite(curve.high)
    if keep.all():
        return curve
    return Curve(curve.label, curve.role, curve.at[keep], curve.value[keep], curve.low[keep], curve.high[keep], curve.band)
