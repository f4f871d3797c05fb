"""What a strip chart can show: one quantity, measured against the twin, with its band."""

from __future__ import annotations

from collections.abc import Iterator

from ddh_twin_py.estimation.sensors import SENSOR_OF_NODE, SENSORS
from ddh_twin_py.gap.watch.watch import HYDRAULIC, TEMPERATURES
from ddh_twin_py.physics.thermal_network import FLOW_PATHS, NODES
from ddh_twin_py.report.units import shown, words
from ddh_twin_py.telemetry.signals import DRIVE_FIELDS, HYDRAULIC_FIELDS
from ddh_twin_py.twin.hydraulic_model import RESIDUAL_SIGNALS
from ddh_twin_py.twin.losses import LOSSES
from ddh_twin_py.web.streams import MOTOR_FIELDS, STATE_FIELDS

FIRST_CHARTS = (
    "pressure_piston_side", "pressure_rod_side", "rod_velocity", "current", "temperature/end_winding", "temperature/tank_oil",
)  # fmt: skip
"""What is charted on a page that nobody has changed yet."""
BAND = 2.0
"""Standard deviations to either side."""
_CELSIUS = {"unit": "°C", "factor": 1.0, "digits": 1}
_DIGITS = {"bar": 1, "mm": 1, "mm/s": 1, "rpm": 0, "A": 2, "V": 0, "W": 0, "N·m": 1, "L/min": 2, "N": 0}


def quantities() -> list[dict]:
    """All of them, in the order of the menu; each with id, label, group, unit, factor from SI, digits and its lines.

    A line has a `column`, a `role` (measured, fused, soft, twin) and a label; `band` names the column of its standard deviation
    (about the line, or about `around`), `spread` says what `BAND` of them are, and `dots` marks readings that come now and then.
    """
    return [*_signals(), *_temperatures(), *_flows_and_powers(), *_losses(), *_heat(), *_oil_flows(), *_gaps(), *_innovations()]


def _quantity(name: str, label: str, group: str, unit: str, lines: list[dict], **more: object) -> dict:
    s = shown(unit)
    return {"id": name, "label": label, "group": group, "unit": s.unit, "factor": s.factor,
            "digits": _DIGITS.get(s.unit, s.digits), "lines": lines, **more}  # fmt: skip


def _line(column: str, role: str, label: str, **more: object) -> dict:
    return {"column": column, "role": role, "label": label, "spread": "2 σ", **more}


def _signals() -> Iterator[dict]:
    """What telemetry tells; most of it the model tells too."""
    noisy = {name for name, _, _ in RESIDUAL_SIGNALS}
    for name in (*DRIVE_FIELDS, *HYDRAULIC_FIELDS):
        stream = "drive" if name in DRIVE_FIELDS else "hydraulics"
        lines = [_line(f"{stream}.{name}", "measured", "measured")]
        if name in noisy:
            lines.append(_line(f"prediction.{name}", "twin", "twin, free run", band=f"noise.{name}", spread="2 × sensor noise"))
        elif name == "speed_command":
            lines[0]["label"] = "commanded"
        yield _quantity(name, words(name), "telemetry", STATE_FIELDS.get(name, "rad/s"), lines)


def _temperatures() -> Iterator[dict]:
    for node in NODES:
        lines = [_line(f"estimate.{node}.temperature", "fused", "twin, fused", band=f"estimate.{node}.standard_deviation"),
                 _line(f"prediction.temperature.{node}", "twin", "twin, free run")]  # fmt: skip
        if node in SENSOR_OF_NODE:
            lines.insert(0, _line(f"{SENSOR_OF_NODE[node]}.reading", "measured", "measured", dots=True))
        yield _temperature(node, words(node), lines)
    yield _temperature("ambient", "ambient", [
        _line("ambient.reading", "measured", "measured", dots=True), _line("estimate.ambient", "fused", "taken by the twin"),
    ])  # fmt: skip
    yield _temperature("hot_spot", "winding hot spot", [_line("motor.hot_spot_temperature", "twin", "twin, from current and speed")])


def _temperature(name: str, label: str, lines: list[dict]) -> dict:
    return {"id": f"temperature/{name}", "label": label, "group": "temperatures", **_CELSIUS, "lines": lines}


def _flows_and_powers() -> Iterator[dict]:
    for name, unit in STATE_FIELDS.items():
        if name in DRIVE_FIELDS or name in HYDRAULIC_FIELDS:
            continue
        group = "flows" if unit == "m3/s" else "power" if unit == "W" else "forces, torques, pump ports"
        lines = [_line(f"state.{name}", "soft", "twin, soft sensor"), _line(f"prediction.{name}", "twin", "twin, free run")]
        yield _quantity(name, words(name), group, unit, lines)


def _losses() -> Iterator[dict]:
    for name in LOSSES:
        lines = [_line(f"state.loss.{name}", "soft", "twin, soft sensor"), _line(f"prediction.loss.{name}", "twin", "twin, free run")]
        yield _quantity(f"loss/{name}", f"loss, {words(name)}", "losses", "W", lines)
    for name in MOTOR_FIELDS:
        if name.endswith(("loss", "teeth", "yoke")):
            lines = [_line(f"motor.{name}", "soft", "twin, from current and speed")]
            yield _quantity(f"motor/{name}", f"motor, {words(name)}", "losses", "W", lines)


def _heat() -> Iterator[dict]:
    for node in NODES:
        lines = [_line(f"state.heat.{node}", "soft", "twin, soft sensor")]
        yield _quantity(f"heat/{node}", f"heat into {words(node)}", "heat by node", "W", lines)


def _oil_flows() -> Iterator[dict]:
    for path in FLOW_PATHS:
        label = words(path).replace(">", " to ")
        yield _quantity(f"flow/{path}", label, "oil between volumes", "m3/s", [_line(f"state.flow.{path}", "soft", "twin, soft sensor")])


def _gaps() -> Iterator[dict]:
    """Departure beyond the normal level, in multiples of the noise floor."""
    for stream, names in (("gap", [name for name, _, _ in HYDRAULIC]), ("temperature_gap", TEMPERATURES)):
        for name in names:
            line = _line(f"{stream}.{name}", "measured", "measured − twin, over noise floor", dots=stream != "gap")
            more = {"zero": True, "floor": 1.0}
            yield {"id": f"gap/{name}", "label": f"gap, {words(name)}", "group": "gap", "unit": "floors", "factor": 1.0, "digits": 2,
                   "lines": [line], **more}  # fmt: skip


def _innovations() -> Iterator[dict]:
    for sensor in SENSORS:
        line = _line(f"innovation.{sensor}.residual", "measured", "reading − expected", band=f"innovation.{sensor}.deviation", around=0.0,
                     dots=True)  # fmt: skip
        yield {"id": f"innovation/{sensor}", "label": f"innovation, {words(sensor)}", "group": "innovations of the filter", "unit": "K",
               "factor": 1.0, "digits": 2, "lines": [line], "zero": True}  # fmt: skip
