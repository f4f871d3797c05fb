"""Names of a gap diagnosis in words of people who know hydraulics and no statistics."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ddh_twin_py.estimation.fitting import binning
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.contract import Shrunk
from ddh_twin_py.gap.explain.learned import PREFIX
from ddh_twin_py.gap.shrink.size import BEGINS
from ddh_twin_py.gap.words import by_component, component_name, signal_name
from ddh_twin_py.report.units import ZERO_CELSIUS, decimals, number, probably, shown, words

__all__ = ["NEAR", "PHASES", "PHASE_MEANING", "UNKNOWN", "VERDICTS", "Place", "axis_scale", "capital", "closed", "component_name",
           "effect_name", "ending", "floors", "leaning", "mostly", "percent", "places", "regime_name", "set_name", "signal_name",
           "strength", "times_floor"]
UNKNOWN = "unknown"
"""Id that stands for an effect outside the catalogue."""
PHASES = (*binning.PHASES, "all")
"""Phases of the contract in the order of a page."""
PHASE_MEANING = {
    "all": "the whole recording",
    "lifting": "the drive moves the rod out",
    "lowering": "the drive moves the rod in",
    "holding": "the drive stands",
    "transient": "within 0.3 s after a step of the speed command",
}
VERDICTS = {
    "no_gap": ("No gap", "good"),
    "explained": ("Explained", "fair"),
    "ambiguous": ("Ambiguous", "fair"),
    "unknown": ("Unknown cause", "poor"),
    "insufficient": ("Cannot tell", "poor"),
}
"""Verdict of the contract to its words and the colour beside them."""
NEAR = BEGINS
"""Multiples of the noise floor up to which a signal counts as explained."""
_FARTHER = 1.1  # times the RMS before, from which a signal ends farther off
_STRENGTH = ((1e4, "overwhelming"), (1e3, "very strong"), (1e2, "strong"), (10.0, "clear"), (4.0, "some"))
_NUMBER = r"[−-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_AMOUNT = re.compile(rf"(?P<low>{_NUMBER}) to (?P<high>{_NUMBER}) (?P<unit>rad/s|Pa|m/s|m|K)$")
_AXIS = re.compile(r"^(?P<name>.*?),? *[\[(]?(?P<unit>rad/s|Pa|m/s|m3/s|N\*m|degC|K|m|s|A|W|V)[\])]?$")


@dataclass(frozen=True)
class Place:
    """A component at which a gap lies: share of the evidence of all its rows, and the largest of these rows."""

    component: str
    share: float
    largest: Mapping
    rows: int


def places(where: Sequence[Mapping]) -> list[Place]:
    """Components of a report's places, that with the largest share first."""
    own = {name: [row for row in where if row["component"] == name] for name in by_component(where)}
    found = [Place(name, round(sum(row["share"] for row in rows), 9), max(rows, key=lambda row: row["share"]), len(rows))
             for name, rows in own.items()]
    return sorted(found, key=lambda place: -place.share)


def mostly(domain: str, phase: str) -> str:
    """Kind and phase in which most of a place's evidence lies."""
    return f"{domain}, " + ("mean of all phases" if phase == "all" else f"most in {phase}")


def effect_name(effect: str) -> str:
    """An effect in words, such as `pump 1: leakage`."""
    if effect == UNKNOWN:
        return "a cause outside the catalogue"
    if effect in EFFECTS and EFFECTS[effect].title:
        return EFFECTS[effect].title
    component, _, name = effect.partition(".")
    return f"{component_name(component)}: {words(name)}" if name else words(effect)


def set_name(effects: tuple[str, ...] | list[str]) -> str:
    """A set of effects in words."""
    return " and ".join(effect_name(e) for e in effects) if effects else "no effect: nothing listed is needed"


def percent(share: float) -> str:
    """A share in percent that never says 0 or 100 where it is not."""
    return probably(share) if 0.0 < share < 1.0 else f"{100.0 * share:.0f} %"


def closed(fraction: float) -> str:
    """The share of a gap that was closed; all of it where what is left lies below the floor, none where it has grown."""
    if fraction >= 1.0:
        return "all"
    return "none" if fraction <= 0.0 else f"{100.0 * fraction:.0f} %"


def floors(gap: float | None, ending: str = " ×") -> str:
    """Multiples of the noise floor, with what they end in; `astray` where a free run went astray, so that there is no number."""
    return "astray" if gap is None or not math.isfinite(gap) else f"{number(gap, 2)}{ending}"


def way_closed(gap: Mapping[str, float | None]) -> str:
    """How much of what the gap of fitted parameters is beyond the floor was closed, with its ends; empty where there is hardly one."""
    fraction = gap["closed_fraction"]
    return "" if fraction is None else f"{closed(fraction)} of the way from {floors(gap['before'], '')} to 1"


def farther_off(shrink: Mapping[str, Shrunk]) -> list[str]:
    """Signals that are left open and end farther off than they were, the farthest first."""
    worse = [name for name, row in shrink.items() if row["after"] > _FARTHER * row["before"] and times_floor(row, "after") > NEAR]
    return sorted(worse, key=lambda name: -times_floor(shrink[name], "after"))


def ending(verdict: str, added: Sequence[str]) -> str:
    """With what the gap at the end was taken: effects or learned terms ``added``, or parameters fitted anew alone."""
    if not added:
        return "parameters refitted"
    if added[0].startswith(PREFIX):
        return "with a learned term"
    return {"explained": "with the cause added", "ambiguous": "with the leading hypothesis"}.get(verdict, "with the best listed hypothesis")


def times_floor(row: Mapping[str, float], when: str) -> float:
    """RMS of a row of the report's shrink over its noise floor; ``when`` is before or after."""
    return row[when] / row["noise"] if row["noise"] > 0.0 else math.inf


def strength(gain: float) -> str:
    """How strong the evidence of a chi-square is, in words; below 4 (two standard deviations) it is chance."""
    return next((word for least, word in _STRENGTH if abs(gain) >= least), "")


def leaning(gain: float) -> str:
    """The same with its direction, such as `strong, for it`."""
    word = strength(gain)
    return f"{word}, {'for' if gain > 0.0 else 'against'} it" if word else "says nothing"


def capital(said: str) -> str:
    """The words with a capital first letter; the others stay."""
    return said[:1].upper() + said[1:]


def regime_name(regime: str) -> str:
    """A regime such as `speed 40 to 80 rad/s` in the units that people read."""
    found = _AMOUNT.search(regime)
    if not found:
        return regime
    unit = shown(found["unit"])
    low, high = (float(found[edge].replace("−", "-")) for edge in ("low", "high"))
    name, shift = unit.unit, 0.0
    if found["unit"] == "K" and low > 200.0:
        name, shift = "°C", ZERO_CELSIUS
    ends = [(v - shift) * unit.factor for v in (low, high)]
    digits = min(unit.digits, decimals(max(map(abs, ends))))
    low, high = (number(v, digits) for v in ends)
    said = f"about {float(low.replace('−', '-')):g}" if low == high else f"{low} to {high}"
    return f"{regime[:found.start()]}{said} {name}"


def axis_scale(name: str, lowest: float) -> tuple[str, str, float, float]:
    """Name, unit that people read, factor and shift of a variable such as `speed, rad/s`: shown = (value - shift) * factor.

    Args:
        name: with its SI unit. lowest: smallest value; kelvin above 200 are absolute temperatures.
    """
    found = _AXIS.match(name.strip())
    if not found or not found["name"].strip():
        return words(name), "", 1.0, 0.0
    said = words(found["name"].strip())
    if found["unit"] in ("K", "degC"):
        absolute = found["unit"] == "K" and math.isfinite(lowest) and lowest > 200.0
        return said, "°C" if absolute or found["unit"] == "degC" else "K", 1.0, ZERO_CELSIUS if absolute else 0.0
    unit = shown(found["unit"])
    return said, unit.unit, unit.factor, 0.0
