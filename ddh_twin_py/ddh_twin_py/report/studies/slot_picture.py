"""The mesh of one slot with its temperatures, as a drawing of a page."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.physics.motor_geometry import ZERO_CELSIUS, Network
from ddh_twin_py.report.page.document import Html, text

_COLOURS = np.array([(33, 44, 110), (62, 108, 168), (96, 164, 168), (190, 203, 130), (236, 172, 74), (214, 88, 52), (150, 24, 40)])
_WIDTH, _MARGIN = 360.0, 12.0


def slot_picture(network: Network, temperature: np.ndarray) -> Html:
    """Drawing of one slot pitch in the middle plane of the stack: each cell in the colour of its temperature.

    Args:
        temperature: of all nodes, K, (n,). The mesh is half a pitch; its mirror image is drawn beside it.
    """
    mesh = network.mesh
    place = np.array(mesh.place)
    plane = np.flatnonzero(np.isclose(place[:, 2], place[:, 2].min()))
    corners = np.array([mesh.corners[i] for i in plane])
    low, high = float(temperature[plane].min()), float(temperature[plane].max())
    half = corners[..., 1].max()
    inner, outer = corners[..., 0].min(), corners[..., 0].max()
    scale = (_WIDTH - 2 * _MARGIN) / (2.0 * half)
    height = (outer - inner) * scale + 2 * _MARGIN
    shapes = []
    for i, shape in zip(plane, corners, strict=True):
        colour = _colour((temperature[i] - low) / ((high - low) or 1.0))
        title = f"{mesh.region[i].replace('_', ' ')}, {temperature[i] - ZERO_CELSIUS:.1f} degC"
        for side in (1.0, -1.0):
            points = " ".join(
                f"{_MARGIN + (half + side * x) * scale:.1f},{_MARGIN + (outer - r) * scale:.1f}" for r, x in shape
            )
            shapes.append(
                f'<polygon points="{points}" fill="{colour}" stroke="#ffffff" stroke-width="0.3"><title>{text(title)}</title></polygon>'
            )
    bar = "".join(
        f'<rect x="{_WIDTH + 16:.0f}" y="{_MARGIN + (1 - (k + 1) / 40) * (height - 2 * _MARGIN):.1f}" width="16" '
        f'height="{(height - 2 * _MARGIN) / 40 + 0.5:.1f}" fill="{_colour((k + 0.5) / 40)}"/>'
        for k in range(40)
    )
    labels = "".join(
        f'<text x="{_WIDTH + 38:.0f}" y="{y:.0f}" font-size="13" fill="currentColor">{value - ZERO_CELSIUS:.1f} °C</text>'
        for value, y in ((high, _MARGIN + 10), (0.5 * (low + high), height / 2 + 4), (low, height - _MARGIN))
    )
    return Html(
        f'<svg role="img" aria-label="Temperatures in one slot pitch, middle of the stack" viewBox="0 0 {_WIDTH + 110:.0f} {height:.0f}" '
        f'style="width:100%;max-width:560px;height:auto;display:block">{"".join(shapes)}{bar}{labels}</svg>'
    )


def _colour(share: float) -> str:
    place = min(max(share, 0.0), 1.0) * (len(_COLOURS) - 1)
    k = min(int(place), len(_COLOURS) - 2)
    red, green, blue = (_COLOURS[k] + (place - k) * (_COLOURS[k + 1] - _COLOURS[k])).round().astype(int)
    return f"#{red:02x}{green:02x}{blue:02x}"
