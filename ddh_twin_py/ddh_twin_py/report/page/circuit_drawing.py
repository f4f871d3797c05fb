"""Drawing of the DDH circuit as inline SVG, coloured by what a page says of each component.

Motor and two pump/motors on one shaft, pump 1 to the piston side (line A), pump 2 to the rod
side (line B), check valves to both lines, relief valve at line B, cylinder with load, tank.
Colours are the classes ``q0`` to ``q5`` of the style sheet, so that the drawing follows light
and dark; every component is a group ``data-component``, so that a live page can recolour it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from ddh_twin_py.report.page.document import Html, text

COMPONENTS = (
    "drive", "motor", "pump_1", "pump_2", "relief_valve", "check_valve", "line_a", "line_b",
    "cylinder", "load", "tank", "oil", "ambient", "sensor",
)
"""Components of the contract, each drawn."""
STEPS = 6
"""Steps of the colour scale; 0 is nothing."""
_WIDTH, _HEIGHT = 780, 460

_SHAPES = {
    "ambient": '<rect class="air" x="4" y="4" width="772" height="452" rx="14"/>',
    "tank": '<path d="M196 350v74h548v-74h-12v62h-524v-62z"/>',
    "oil": f'<path d="M208 372{"q17-6 34 0t34 0" * 7}h48v40h-524z"/>',
    "line_a": '<path class="pipe-edge" d="M290 222V80h42"/><path class="pipe" d="M290 222V80h42"/>',
    "line_b": '<path class="pipe-edge" d="M520 222V160h28V119"/><path class="pipe" d="M520 222V160h28V119"/>',
    "drive": '<rect x="24" y="230" width="68" height="44" rx="4"/><path class="detail" d="M36 262l10-20 12 20 12-20 10 20"/>',
    "motor": '<circle cx="164" cy="252" r="36"/><text class="symbol" x="164" y="260">M</text>',
    "pump_1": '<circle cx="290" cy="252" r="30"/><path class="detail solid" d="M282 235h16l-8-13zM282 269h16l-8 13z"/>',
    "pump_2": '<circle cx="520" cy="252" r="30"/><path class="detail solid" d="M512 235h16l-8-13zM512 269h16l-8 13z"/>',
    "check_valve": (
        '<path class="thin" d="M228 392V328M228 298V186h56M580 392V328M580 298V160"/>'
        '<circle cx="228" cy="313" r="15"/><path class="detail" d="M218 313l10 8 10-8"/>'
        '<circle cx="580" cy="313" r="15"/><path class="detail" d="M570 313l10 8 10-8"/>'
        '<circle class="detail solid" cx="228" cy="310" r="5"/><circle class="detail solid" cx="580" cy="310" r="5"/>'
    ),
    "relief_valve": (
        '<path class="thin" d="M554 160h96v78M650 274v8h-48v60h-22"/>'
        '<rect x="632" y="238" width="36" height="36"/><path class="detail" d="M650 242v26m-5-7l5 7 5-7M632 242l-6 5 6 6-6 6 6 6-6 5"/>'
    ),
    "cylinder": '<rect x="330" y="40" width="236" height="80" rx="3"/><path class="detail solid" d="M420 42h14v76h-14z"/>'
                '<path class="rod" d="M434 74h198v12H434z"/>',
    "load": '<rect x="632" y="44" width="76" height="72" rx="2"/><path class="detail" d="M654 80h32m-9-7l9 7-9 7"/>',
}
_SENSORS = (  # where a sensor is drawn, its letter, and the signals of which one is enough to draw it
    (309, 146, "p", ("pressure_piston_side",)), (567, 143, "p", ("pressure_rod_side",)), (592, 56, "x", ("rod_position", "rod_velocity")),
    (192, 284, "T", ("temperature/motor_winding", "temperature/motor_housing")), (314, 284, "T", ("temperature/pump_1_case",)),
    (544, 284, "T", ("temperature/pump_2_case",)), (714, 394, "T", ("temperature/tank_oil", "temperature/tank_wall")),
)
_CONNECTIONS = '<path class="shaft" d="M200 252h60M320 252h170"/><path class="thin" d="M92 252h36M290 282v110M520 282v110"/>'
_LABEL = {  # where name and value stand: x, y, anchor, on one line
    "drive": (24, 294, "start", False), "motor": (164, 190, "middle", False), "pump_1": (308, 198, "start", False),
    "pump_2": (510, 308, "end", False), "relief_valve": (610, 304, "start", False), "check_valve": (206, 344, "end", False),
    "line_a": (278, 124, "end", False), "line_b": (510, 148, "end", False), "cylinder": (448, 29, "middle", True),
    "load": (670, 135, "middle", False), "tank": (470, 445, "middle", True), "oil": (470, 402, "middle", True),
    "ambient": (20, 29, "start", True), "sensor": (20, 412, "start", False),
}
_NAME = {
    "drive": "drive", "motor": "motor", "pump_1": "pump 1", "pump_2": "pump 2", "relief_valve": "relief valve",
    "check_valve": "check valves", "line_a": "line A", "line_b": "line B", "cylinder": "cylinder", "load": "load", "tank": "tank",
    "oil": "oil", "ambient": "ambient air", "sensor": "sensors",
}
_ORDER = ("ambient", "oil", "tank", "check_valve", "relief_valve", "line_a", "line_b", "cylinder", "load", "drive", "motor",
          "pump_1", "pump_2", "sensor")


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


def circuit_drawing(tints: Mapping[str, Tint], caption: str, recorded: Collection[str] | None = None,
                    erring: Collection[str] = ()) -> Html:
    """The drawing.

    Args:
        tints: component to what is said of it; the others stay plain. caption: read aloud for the picture.
        recorded: signals whose sensors are drawn; None for all. erring: signals whose sensors take the colour of sensors; empty: all.

    Raises:
        ValueError: a component that is not one of `COMPONENTS`.
    """
    for component in tints:
        if component not in COMPONENTS:
            raise ValueError(f"no component {component!r} in the drawing; valid are {', '.join(COMPONENTS)}")
    parts = "".join(_component(name, tints.get(name), recorded, erring) + (_CONNECTIONS if name == "tank" else "") for name in _ORDER)
    labels = "".join(_words(name, tints.get(name)) for name in _ORDER)
    return Html(
        f'<svg class="circuit" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{text(caption)}">{parts}{labels}</svg>'
    )


def scale() -> Html:
    """What the colours stand for."""
    edges = ("none", "up to 5 %", "5 to 15 %", "15 to 35 %", "35 to 60 %", "above 60 %")
    items = "".join(f'<li><i class="q{i}"></i>{edge}</li>' for i, edge in enumerate(edges))
    return Html(f'<ul class="key scale"><li>Share of the evidence:</li>{items}</ul>')


def _component(name: str, tint: Tint | None, recorded: Collection[str] | None, erring: Collection[str]) -> str:
    title = f"<title>{text(tint.title or f'{_NAME[name]}: {tint.label}')}</title>" if tint else f"<title>{_NAME[name]}</title>"
    shape = _sensors(recorded, erring) if name == "sensor" else _SHAPES[name]
    return f'<g data-component="{name}" class="q{tint.step if tint else 0}">{title}{shape}</g>'


def _sensors(recorded: Collection[str] | None, erring: Collection[str]) -> str:
    drawn = []
    for x, y, letter, signals in _SENSORS:
        if recorded is None or any(name in recorded for name in signals):
            sound = bool(erring) and not any(name in erring for name in signals)
            own, tag = (' class="q0"', "tag q0") if sound else ("", "tag")
            drawn.append(f'<circle{own} cx="{x}" cy="{y}" r="11"/><text class="{tag}" x="{x}" y="{y + 4}">{letter}</text>')
    return "".join(drawn)


def _words(name: str, tint: Tint | None) -> str:
    x, y, anchor, one_line = _LABEL[name]
    said = tint.label if tint else ""
    if not said or one_line:
        value = f' <tspan class="value">{text(said)}</tspan>' if said else ""
        down = 16 if name == "motor" else 0  # its words stand above it
        return f'<text x="{x}" y="{y + down}" text-anchor="{anchor}">{_NAME[name]}{value}</text>'
    return (f'<text x="{x}" y="{y}" text-anchor="{anchor}">{_NAME[name]}</text>'
            f'<text class="value" x="{x}" y="{y + 17}" text-anchor="{anchor}">{text(said)}</text>')
