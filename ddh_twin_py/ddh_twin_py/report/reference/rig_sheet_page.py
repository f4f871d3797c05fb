"""The reference sheet as a page of Markdown: every number that a rig file may set, with what is allowed."""

from __future__ import annotations

from ddh_twin_py.rig import Quantity, load_rig
from ddh_twin_py.rig.sheet import BOUNDS, SENSOR_ROW, SensorSpec

_FOOT = "*Written by `scripts/reference_pages.py` from `rig/ddh_rig.yaml` and `rig/extensions.yaml`; change it there.*"


def rig_sheet_page() -> str:
    """The page, for `docs/rig_sheet.md`."""
    rig = load_rig()
    lines = [
        "# The rig sheet", "",
        "Every number that a rig file may set: `path.to.it: {value, unit, tolerance, source}`, nested as YAML. A rig file holds what "
        "differs from this sheet ([how to](howto_rig_sheet.md)). Tolerance is one relative standard deviation, 0 is exact; a value "
        "beyond what is allowed is a mistake of unit or typing and is refused. What the symbols mean: [physics](physics.md).", "",
    ]
    sections: dict[str, list[str]] = {}
    for path in rig.quantities:
        sections.setdefault(path.split(".")[0], []).append(path)
    for section, paths in sections.items():
        lines += [f"## {section}", "", "| path | value | unit | tolerance | allowed | source |", "|---|---|---|---|---|---|"]
        lines += [_row(path, rig.quantities[path]) for path in paths]
        lines.append("")
    keys = ", ".join(f"`{key}`" for key in SENSOR_ROW)
    lines += ["## sensors", "", f"A row says what differs: some of {keys}. What it leaves out is this sheet's; `unit` is needed beside "
              "`noise`, `offset_tolerance` and `full_scale`. A reading of the size of `full_scale` or more is saturated: it is told and "
              "not used (temperatures in K above absolute zero: 473.15 for a sensor of up to 200 degC).", "",
              "| sensor | noise of a sample | tolerance of the zero | full scale | unit |", "|---|---|---|---|---|"]
    lines += [f"| `sensors.{name}` | {spec.noise:g} | {spec.offset_tolerance:g} | {_scale(spec)} | {spec.unit} |"
              for name, spec in rig.sensors.items()]
    return "\n".join([*lines, "", _FOOT, ""])


def _scale(spec: SensorSpec) -> str:
    return "not known" if spec.full_scale is None else f"{spec.full_scale:g}"


def _row(path: str, quantity: Quantity) -> str:
    bound = BOUNDS[path]
    unit = "" if quantity.unit == "1" else quantity.unit
    source = quantity.source.replace("|", "\\|")
    spread = f"{quantity.std:g} {unit}".strip() if quantity.std is not None else f"{quantity.tolerance:g}"
    return f"| `{path}` | {quantity.value:g} | {unit} | {spread} | {bound.lowest:.3g} to {bound.highest:.3g} | {source} |"
