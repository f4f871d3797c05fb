"""Drawing of the DDH circuit as inline SVG, coloured by what a page says of each component.

Motor and two pump/motors on one shaft, pump 1 to the piston side (line A), pump 2 to the rod
side (line B), check valves to both lines, relief valve at line B, cylinder with load, tank.
Colours are the classes ``q0`` to ``q5`` of the style sheet, so that the drawing follows light
and dark; every component is a group ``data-component``, so that a live page can recolour it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ddh_twin_py.report.document import Html, text

COMPONENTS = (
    "drive", "motor", "pump_1", "pump_2", "relief_valve", "check_valve", "line_a", "line_b",
    "cylinder", "load", "tank", "oil", "ambient", "sensor",
)
"""Components of the contract, each drawn."""
STEPS = 6
"""Steps of the colour scale; 0 is nothing."""
_WIDTH, _HEIGHT = 680, 440

_SHAPES = {
    "ambient": '<rect class="air" x="4" y="4" width="672" height="432" rx="14"/>',
    "tank": '<path d="M232 350h-12v76h440v-76h-12v64h-416z"/>',
    "oil": '<path d="M232 372q17-6 34 0t34 0 34 0 34 0 34 0 34 0 34 0 34 0 34 0 34 0 34 0 34 0 8 0v42h-416z"/>',
    "line_a": '<path class="pipe-edge" d="M270 222V80h50"/><path class="pipe" d="M270 222V80h50"/>',
    "line_b": '<path class="pipe-edge" d="M410 222V170h96V134"/><path class="pipe" d="M410 222V170h96V134"/>',
    "drive": '<rect x="26" y="230" width="66" height="44" rx="4"/><path class="detail" d="M40 262l14-20 8 20 8-20 8 20"/>',
    "motor": '<circle cx="160" cy="252" r="36"/><text class="symbol" x="160" y="260">M</text>',
    "pump_1": '<circle cx="270" cy="252" r="30"/><path class="detail solid" d="M262 223h16l-8 13zM262 281h16l-8-13z"/>',
    "pump_2": '<circle cx="410" cy="252" r="30"/><path class="detail solid" d="M402 223h16l-8 13zM402 281h16l-8-13z"/>',
    "check_valve": (
        '<path class="thin" d="M214 372V322M214 292V196h56M470 372V322M470 292V170"/>'
        '<circle cx="214" cy="307" r="15"/><path class="detail" d="M204 303l10-8 10 8"/><circle class="detail solid" cx="214" cy="309" r="5"/>'
        '<circle cx="470" cy="307" r="15"/><path class="detail" d="M460 303l10-8 10 8"/><circle class="detail solid" cx="470" cy="309" r="5"/>'
    ),
    "relief_valve": (
        '<path class="thin" d="M506 170h54v94M560 300v72"/>'
        '<rect x="542" y="264" width="36" height="36"/><path class="detail" d="M560 268v26m-5-7l5 7 5-7M580 270l5 6-5 6 5 6-5 6"/>'
    ),
    "cylinder": '<rect x="300" y="40" width="226" height="80" rx="3"/><path class="detail solid" d="M384 42h14v76h-14z"/>'
                '<path class="rod" d="M398 74h170v12H398z"/>',
    "load": '<rect x="568" y="44" width="74" height="72" rx="2"/><path class="detail" d="M588 80h32m-9-7l9 7-9 7"/>',
    "sensor": "".join(
        f'<circle cx="{x}" cy="{y}" r="11"/><text class="tag" x="{x}" y="{y + 4}">{letter}</text>'
        for x, y, letter in ((288, 138, "p"), (524, 152, "p"), (548, 56, "x"), (188, 284, "T"), (292, 284, "T"), (630, 394, "T"))
    ),
}
_CONNECTIONS = (
    '<path class="thin" d="M92 252h32"/><path class="shaft" d="M196 252h44M300 252h80"/>'
    '<path class="thin" d="M270 282v90M410 282v90"/><path class="thin" d="M506 134v-14"/>'
)
_LABEL = {  # where name and value stand: x, y, anchor
    "drive": (59, 296, "middle"), "motor": (160, 206, "middle"), "pump_1": (312, 296, "start"), "pump_2": (406, 306, "end"),
    "relief_valve": (592, 286, "start"), "check_valve": (194, 322, "end"), "line_a": (258, 128, "end"), "line_b": (400, 196, "end"),
    "cylinder": (412, 28, "middle"), "load": (605, 134, "middle"), "tank": (440, 436, "middle"), "oil": (344, 400, "middle"),
    "ambient": (20, 26, "start"), "sensor": (20, 400, "start"),
}
_NAME = {
    "drive": "drive", "motor": "motor", "pump_1": "pump 1", "pump_2": "pump 2", "relief_valve": "relief valve", "check_valve": "check valves",
    "line_a": "line A", "line_b": "line B", "cylinder": "cylinder", "load": "load", "tank": "tank", "oil": "oil", "ambient": "ambient air",
    "sensor": "sensors",
}
_ORDER = ("ambient", "oil", "tank", "check_valve", "relief_valve", "line_a", "line_b", "cylinder", "load", "drive", "motor", "pump_1", "pump_2", "sensor")
_ABOVE = ("motor", "cylinder")


@dataclass(frozen=True)
class Tint:
    """What is said of one component: step of the colour scale 0 to 5, words drawn beside it, words under the pointer."""

    step: int
    label: str
    title: str = ""


def step_of(share: float) -> int:
    """Step of the colour scale for a share of the whole; above 0 at least 1."""
    if share <= 0.0:
        return 0
    return 1 + sum(share > edge for edge in (0.05, 0.15, 0.35, 0.6))


def circuit_drawing(tints: Mapping[str, Tint], caption: str) -> Html:
    """The drawing.

    Args:
        tints: component to what is said of it; the others stay plain. caption: read aloud for the picture.

    Raises:
        ValueError: a component that is not one of `COMPONENTS`.
    """
    for component in tints:
        if component not in COMPONENTS:
            raise ValueError(f"no component {component!r} in the drawing; valid are {', '.join(COMPONENTS)}")
    parts = "".join(_component(name, tints.get(name)) + (_CONNECTIONS if name == "ambient" else "") for name in _ORDER)
    labels = "".join(_words(name, tints.get(name)) for name in _ORDER)
    return Html(
        f'<svg class="circuit" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{text(caption)}">{parts}{labels}</svg>'
    )


def scale() -> Html:
    """What the colours stand for."""
    edges = ("none", "up to 5 %", "5 to 15 %", "15 to 35 %", "35 to 60 %", "above 60 %")
    items = "".join(f'<li><i class="q{i}"></i>{edge}</li>' for i, edge in enumerate(edges))
    return Html(f'<ul class="key scale"><li>Share of what is missing:</li>{items}</ul>')


def _component(name: str, tint: Tint | None) -> str:
    title = f"<title>{text(tint.title or f'{_NAME[name]}: {tint.label}')}</title>" if tint else f"<title>{_NAME[name]}</title>"
    return f'<g data-component="{name}" class="q{tint.step if tint else 0}">{title}{_SHAPES[name]}</g>'


def _words(name: str, tint: Tint | None) -> str:
    x, y, anchor = _LABEL[name]
    said = tint.label if tint else ""
    inside = ' class="on-oil"' if name == "oil" else ""
    if not said:
        return f'<text x="{x}" y="{y}" text-anchor="{anchor}"{inside}>{_NAME[name]}</text>'
    if name in ("oil", "tank", "ambient", "cylinder"):  # on one line
        return f'<text x="{x}" y="{y}" text-anchor="{anchor}"{inside}>{_NAME[name]} <tspan class="value">{text(said)}</tspan></text>'
    first, second = (y - 16, y) if name in _ABOVE else (y, y + 16)
    return (
        f'<text x="{x}" y="{first}" text-anchor="{anchor}">{_NAME[name]}</text>'
        f'<text class="value" x="{x}" y="{second}" text-anchor="{anchor}">{text(said)}</text>'
    )
