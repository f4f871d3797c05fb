"""A map as inline SVG: coloured cells with what they hold, and lines where the answer changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from ddh_twin_py.report.page.document import Html

CIVIDIS = ("#00224e", "#35456c", "#666970", "#948e77", "#c8b866", "#fee838")
"""Dark to light, read alike with and without colour vision (Nunez et al. 2018)."""
_TOP, _BOTTOM = 8, 44
_NARROWEST = 0.8  # of its width, to which a map shrinks before it scrolls


@dataclass(frozen=True)
class Grid:
    """Sizes in pixels: width and height of a cell, room for the names of the rows."""

    cell: int = 66
    row: int = 34
    left: int = 92


@dataclass(frozen=True)
class Cell:
    """One cell: fill as #rrggbb, words in it, what is said when the pointer rests on it, and the group it belongs to."""

    fill: str
    label: str
    title: str
    group: str


def heatmap(columns: Sequence[str], rows: Sequence[str], cells: Sequence[Sequence[Cell]], x_title: str, caption: str,
            grid: Grid = Grid()) -> Html:
    """A figure: one cell per row and column, a line between neighbours of different groups.

    Args:
        columns, rows: names along the axes. cells: by row, then column. grid: sizes.
    """
    width, height = grid.left + grid.cell * len(columns) + 6, _TOP + grid.row * len(rows) + _BOTTOM
    parts = []
    for i, row in enumerate(cells):
        y = _TOP + grid.row * i
        parts.append(f'<text x="{grid.left - 8}" y="{y + grid.row / 2 + 4}" text-anchor="end" class="axis">{escape(rows[i])}</text>')
        for j, cell in enumerate(row):
            x = grid.left + grid.cell * j
            parts.append(
                f'<g><title>{escape(cell.title)}</title><rect x="{x}" y="{y}" width="{grid.cell}" height="{grid.row}" fill="{cell.fill}"/>'
                f'<text x="{x + grid.cell / 2}" y="{y + grid.row / 2 + 4}" text-anchor="middle"'
                f' fill="{ink_on(cell.fill)}">{escape(cell.label)}</text></g>'
            )
    for j, name in enumerate(columns):
        parts.append(f'<text x="{grid.left + grid.cell * (j + 0.5)}" y="{_TOP + grid.row * len(rows) + 17}" text-anchor="middle"'
                     f' class="axis">{escape(name)}</text>')
    parts.append(
        f'<text x="{grid.left + grid.cell * len(columns) / 2}" y="{height - 6}" text-anchor="middle"'
        f' class="axis">{escape(x_title)}</text>'
    )
    edges = "".join(_edges(cells, grid))
    parts.append(f'<path d="{edges}" class="flip-under"/><path d="{edges}" class="flip"/>')
    return Html(
        f'<div class="map"><p class="caption">{escape(caption)}</p><div class="scroll" tabindex="0">'
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" style="min-width:{_NARROWEST * width:.0f}px" '
        f'role="img" aria-label="{escape(caption)}">'
        f"{''.join(parts)}</svg></div></div>"
    )


def _edges(cells: Sequence[Sequence[Cell]], grid: Grid) -> list[str]:
    lines = []
    for i, row in enumerate(cells):
        for j, cell in enumerate(row):
            x, y = grid.left + grid.cell * j, _TOP + grid.row * i
            if j + 1 < len(row) and row[j + 1].group != cell.group:
                lines.append(f"M{x + grid.cell} {y}v{grid.row}")
            if i + 1 < len(cells) and cells[i + 1][j].group != cell.group:
                lines.append(f"M{x} {y + grid.row}h{grid.cell}")
    return lines


def on_scale(value: float, low: float, high: float) -> str:
    """Colour of a value between low and high on `CIVIDIS`, as #rrggbb."""
    place = min(max((value - low) / ((high - low) or 1.0), 0.0), 1.0) * (len(CIVIDIS) - 1)
    k = min(int(place), len(CIVIDIS) - 2)
    a, b = (tuple(int(colour[n:n + 2], 16) for n in (1, 3, 5)) for colour in CIVIDIS[k:k + 2])
    return "#" + "".join(f"{round(p + (q - p) * (place - k)):02x}" for p, q in zip(a, b, strict=True))


def ink_on(fill: str) -> str:
    """Black or white, whichever stands out more on a fill (relative luminance of WCAG 2)."""
    red, green, blue = (int(fill[n:n + 2], 16) / 255.0 for n in (1, 3, 5))
    light = sum(w * (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4)
                for w, c in zip((0.2126, 0.7152, 0.0722), (red, green, blue), strict=True))
    return "#000000" if light > 0.18 else "#ffffff"
