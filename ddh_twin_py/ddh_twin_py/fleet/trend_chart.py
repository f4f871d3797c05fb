"""A small chart over dates as inline SVG: points with error bars, joined by a line."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape

from ddh_twin_py.report.page.document import Html

_WIDTH, _HEIGHT = 620, 190
_LEFT, _RIGHT, _TOP, _BOTTOM = 84, 14, 12, 34
_TICKS = 5
_SHORT = 3.0 * 86400.0  # s, below which hours are shown


@dataclass(frozen=True)
class Line:
    """One line: `role` is its colour (`charts.ROLES`); `points` are UTC time, value, standard deviation (None: not known) and a title."""

    label: str
    role: str
    points: Sequence[tuple[datetime, float, float | None, str]]


def trend_chart(title: str, unit: str, lines: Sequence[Line], level: tuple[str, float] | None = None,
                span: Sequence[datetime] = ()) -> Html:
    """The chart; `level` is a label and a value drawn as a broken line, `span` are times that the axis reaches to as well, so that charts
    have it in common. Empty where there is no point."""
    points = [point for line in lines for point in line.points]
    if not points:
        return Html("")
    times = [time.timestamp() for time in (*span, *(point[0] for point in points))]
    values = [value + sign * 2.0 * (deviation or 0.0) for _, value, deviation, _ in points for sign in (-1.0, 1.0)]
    if level is not None:
        values.append(level[1])
    x, y = _Axis(min(times), max(times), _LEFT, _WIDTH - _RIGHT), _Axis(*_padded(min(values), max(values)), _HEIGHT - _BOTTOM, _TOP)
    parts = [*_frame(x, y)]
    if level is not None:
        at = y.place(level[1])
        parts.append(f'<path d="M{_LEFT} {at:.1f}H{_WIDTH - _RIGHT}" stroke="var(--ink-2)" stroke-dasharray="4 4" fill="none"/>'
                     f'<text x="{_WIDTH - _RIGHT}" y="{at - 4:.1f}" text-anchor="end" class="axis">{escape(level[0])}</text>')
    for line in lines:
        parts += _drawn(line, x, y)
    legend = ", ".join(f'<span style="color:var(--s-{line.role})">●</span> {escape(line.label)}' for line in lines)
    named = f'{escape(title)}, <span class="axis">{escape(unit)}</span>' if unit else escape(title)
    caption = f"{named}: {legend}" if len(lines) > 1 else named
    return Html(
        f'<div class="map"><p class="caption">{caption}</p><div class="scroll" tabindex="0">'
        f'<svg class="trend" viewBox="0 0 {_WIDTH} {_HEIGHT}" width="{_WIDTH}" height="{_HEIGHT}" role="img" '
        f'aria-label="{escape(title)} over time">'
        f"{''.join(parts)}</svg></div></div>"
    )


@dataclass(frozen=True)
class _Axis:
    low: float
    high: float
    first: float
    last: float

    def place(self, value: float) -> float:
        """Pixel of a value; the middle where there is but one."""
        share = (value - self.low) / (self.high - self.low) if self.high > self.low else 0.5
        return self.first + share * (self.last - self.first)


def _padded(low: float, high: float) -> tuple[float, float]:
    pad = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    return low - pad, high + pad


def _steps(low: float, high: float) -> list[float]:
    """Round values within a span."""
    raw = (high - low) / 4.0
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= raw)
    return [n * step for n in range(math.ceil(low / step), math.floor(high / step) + 1)]


def _frame(x: _Axis, y: _Axis) -> list[str]:
    parts = []
    for value in _steps(y.low, y.high):
        at = y.place(value)
        parts.append(f'<path d="M{_LEFT} {at:.1f}H{_WIDTH - _RIGHT}" stroke="var(--ink-2)" stroke-opacity="0.2" fill="none"/>'
                     f'<text x="{_LEFT - 8}" y="{at + 4:.1f}" text-anchor="end" class="axis">{value:.4g}</text>')
    short = x.high - x.low < _SHORT
    form = "%Y-%m-%d %H:%M" if short else "%Y-%m-%d"
    count = (_TICKS - short) if x.high > x.low else 1  # labels with hours are longer
    for n in range(count):
        second = x.low + (x.high - x.low) * n / max(1, count - 1)
        anchor = "middle" if count == 1 else "start" if n == 0 else "end" if n == count - 1 else "middle"
        label = datetime.fromtimestamp(second, UTC).strftime(form)
        name = "axis" if n in (0, count - 1) or 2 * n == count - 1 else "axis finer"
        parts.append(f'<text x="{x.place(second):.1f}" y="{_HEIGHT - 12}" text-anchor="{anchor}" class="{name}">{label}</text>')
    return parts


def _drawn(line: Line, x: _Axis, y: _Axis) -> list[str]:
    colour, placed = f"var(--s-{line.role})", sorted(line.points, key=lambda point: point[0])
    at = [(x.place(time.timestamp()), y.place(value)) for time, value, _, _ in placed]
    path = "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in at)
    parts = [f'<path d="{path}" stroke="{colour}" stroke-width="1.5" fill="none"/>'] if len(at) > 1 else []
    for (a, b), (_, value, deviation, title) in zip(at, placed, strict=True):
        bar = ""
        if deviation:
            low, high = y.place(value - 2.0 * deviation), y.place(value + 2.0 * deviation)
            bar = f'<path d="M{a:.1f} {low:.1f}V{high:.1f}" stroke="{colour}" fill="none"/>'
        parts.append(f'<g><title>{escape(title)}</title>{bar}<circle cx="{a:.1f}" cy="{b:.1f}" r="4" fill="{colour}"/></g>')
    return parts
