"""The catalogue of effects as Markdown: a page per effect and an index, for `docs/effects`."""

from __future__ import annotations

import math

from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.effect import DOMAINS, Effect
from ddh_twin_py.report.gap.words import capital, component_name, effect_name
from ddh_twin_py.report.safety import BEFORE, SAFETY
from ddh_twin_py.report.units import shown, words
from ddh_twin_py.rig import load_rig

INDEX = "README.md"
_SAFETY = f"**{BEFORE}** {SAFETY}"
_FOOT = "*Written by `scripts/effect_pages.py` from `ddh_twin_py/gap/catalogue`; change it there.*"


def effect_pages() -> dict[str, str]:
    """File name to text of every page, the index included."""
    return {INDEX: _index(), **{f"{effect.id}.md": _page(effect) for effect in EFFECTS.values()}}


def _index() -> str:
    lines = [
        "# Effects that a gap diagnosis may name", "",
        f"{len(EFFECTS)} effects by domain. An effect is an extension of the twin with a neutral value, at which the twin is as its sheet "
        "says; each page says by what law it acts, what it shows in the signals, what it is easily taken for, and how to check it on the "
        "machine.", "",
        _SAFETY, "",
    ]
    for domain in DOMAINS:
        lines += [f"## {capital(domain)}", "", "| effect | what happens |", "|---|---|"]
        lines += [f"| {_link(e)} | {_cell(_both(e))} |" for e in EFFECTS.values() if e.domain == domain]
        lines.append("")
    return "\n".join([*lines, _FOOT, ""])


def _page(effect: Effect) -> str:
    lines = [
        f"# {capital(effect_name(effect.id))}", "",
        f"`{effect.id}`: {effect.domain}, {component_name(effect.component)}. [All effects]({INDEX})", "",
        _both(effect), "",
        _SAFETY, "",
        "| | |", "|---|---|",
        f"| law | `{_cell(effect.law)}` |",
        f"| what is reported | {words(effect.parameter)}{_unit(effect)} |",
        f"| without the effect | {_number(_reference(effect), effect.unit)} |",
        f"| looked for | {_range(effect)} |",
        f"| what it shows | {_cell(effect.signature)} |",
        f"| how to check on the machine | {_cell(effect.check)} |", "",
        "## What it is easily taken for", "",
    ]
    if effect.confused_with:
        lines += ["| effect | what that one shows | how to check that one |", "|---|---|---|"]
        others = [EFFECTS[other] for other in effect.confused_with]
        lines += [f"| {_link(other)} | {_cell(other.signature)} | {_cell(other.check)} |" for other in others]
    else:
        lines.append("No other effect of the catalogue.")
    return "\n".join([*lines, "", _FOOT, ""])


def _both(effect: Effect) -> str:
    """What happens, in both directions where it may act in both."""
    above, below = effect.happens(1.0), effect.happens(-1.0)
    return f"{above} Or: {below[:1].lower()}{below[1:]}" if effect.about_below else above


def _link(effect: Effect) -> str:
    return f"[{effect_name(effect.id)}]({effect.id}.md)"


def _cell(said: str) -> str:
    return said.replace("|", "\\|")


def _reference(effect: Effect) -> float:
    return effect.reference(load_rig().parameters)


def _unit(effect: Effect) -> str:
    return "" if effect.unit == "1" else f", {effect.unit}"


def _number(value: float, unit: str) -> str:
    """A value in SI and, where people read another unit, in that."""
    said = f"{value:.4g}" if unit == "1" else f"{value:.4g} {unit}"
    s = shown(unit)
    return said if s.factor == 1.0 or value == 0.0 else f"{said} ({value * s.factor:.4g} {s.unit})"


def _range(effect: Effect) -> str:
    low, high = (_reference(effect) + departure for departure in (effect.lowest, effect.highest))
    if math.isinf(low) or math.isinf(high):
        return "any value" if math.isinf(low) and math.isinf(high) else (
            f"from {_number(low, effect.unit)} on" if math.isinf(high) else f"up to {_number(high, effect.unit)}")
    return f"{_number(low, effect.unit)} to {_number(high, effect.unit)}"
