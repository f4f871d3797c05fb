"""Write a rig as a file that `sheet.load_rig` reads back exactly: what differs from the reference sheet.

Of each entry the file has value, unit, tolerance of the sheet, standard deviation where a fit gave
one, and source. Correlations between fitted values have no place in it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import yaml

from ddh_twin_py.rig.bounds import contradiction
from ddh_twin_py.rig.files import printable, write_whole
from ddh_twin_py.rig.sheet import BOUNDS, Quantity, Rig, RigError, SensorSpec, load_rig


def write_rig(path: str | Path, rig: Rig, heading: str = "") -> Path:
    """Write the file whole or not at all, making its folder where needed; see `rig_text`."""
    return write_whole(path, rig_text(rig, heading))


def rig_text(rig: Rig, heading: str = "") -> str:
    """The rig as YAML: its name, and every entry that is not the reference sheet's.

    Args:
        rig: the rig. heading: lines of comment for the top; what no comment may hold is spelled out.

    Raises:
        RigError: a value that no rig file may have.
    """
    reference = load_rig()
    quantities = {path: q for path, q in rig.quantities.items() if q != reference.quantities[path]}
    for path, quantity in quantities.items():
        if not BOUNDS[path].holds(quantity.value) or not math.isfinite(quantity.value):
            raise RigError(f"{path}: value is {quantity.value:g} {quantity.unit}, allowed are {BOUNDS[path].lowest:.4g} "
                           f"to {BOUNDS[path].highest:.4g}; a rig file cannot hold it")
    odd = contradiction({path: q.value for path, q in rig.quantities.items()})
    if odd:
        raise RigError(odd)
    tree: dict = {}
    for path, quantity in quantities.items():
        *sections, name = path.split(".")
        node = tree
        for section in sections:
            node = node.setdefault(section, {})
        node[name] = _Leaf(_entry(quantity))
    _add_sensors(tree, rig.sensors, reference.sensors)
    lines = [f"# {printable(line)}".rstrip() for line in heading.splitlines()]
    lines.append(f"rig_id: {_flow(rig.rig_id)}")
    lines += _lines(tree, 0)
    return "\n".join(lines) + "\n"


class _Leaf(dict):
    """An entry on one line."""


def _entry(quantity: Quantity) -> dict:
    entry: dict = {"value": float(quantity.value), "unit": quantity.unit}
    if quantity.std is not None:
        entry["std"] = float(quantity.std)
    return {**entry, "tolerance": quantity.tolerance, "source": quantity.source}


def _add_sensors(tree: dict, sensors: Mapping[str, SensorSpec], reference: Mapping[str, SensorSpec]) -> None:
    """Rows of sensors that differ; a row that holds a changed time constant is written whole."""
    inside = tree.pop("sensors", {})
    rows = {}
    for name, spec in sensors.items():
        if spec != reference[name] or name in inside:
            row = {"noise": spec.noise, "unit": spec.unit, "offset_tolerance": spec.offset_tolerance}
            if spec.full_scale != reference[name].full_scale:
                row["full_scale"] = spec.full_scale
            rows[name] = _Leaf({**row, **inside.get(name, {})})
    if rows:
        tree["sensors"] = rows


def _lines(tree: Mapping, depth: int) -> list[str]:
    lines = []
    for name, node in tree.items():
        begin = f"{'  ' * depth}{name}:"
        lines += [f"{begin} {_flow(dict(node))}"] if isinstance(node, _Leaf) else [begin, *_lines(node, depth + 1)]
    return lines


def _flow(value: object) -> str:
    """One line of YAML."""
    plain = {k: dict(v) if isinstance(v, _Leaf) else v for k, v in value.items()} if isinstance(value, dict) else [value]
    text = yaml.safe_dump(plain, default_flow_style=True, sort_keys=False, width=math.inf, allow_unicode=True).strip()
    return text if isinstance(value, dict) else text[1:-1]
