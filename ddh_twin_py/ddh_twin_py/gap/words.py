"""A verdict in words."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from ddh_twin_py.gap.contract import Place, Report
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.shrink.size import BEGINS, of_all
from ddh_twin_py.names import first_of
from ddh_twin_py.rig.reader_units import plain, plus_minus, probably, shown
from ddh_twin_py.rig.sheet import CUT
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

BUT = "But "
"""Begin of the sentence on what may have changed without a recording telling."""
_DIFFERS = 0.05  # by which another probability is worth a word
_SURE, _OTHERS = 0.7, 2  # probability from which a place is named alone; how many others are named else
_CLOSED_BY = 1.2  # times what is left, from which it is said what closes a gap
_HARDLY = 0.9  # of the gap without a cause: more than that is left with it where it hardly closes anything
_NAMES = {
    "pressure_piston_side": "pressure, piston side", "pressure_rod_side": "pressure, rod side", "rod_position": "stroke error",
    "electrical_power": "electrical power", "pump_1": "pump 1", "pump_2": "pump 2", "line_a": "line A", "line_b": "line B",
}
_PLAIN, _COUNTS = 0.8, 0.1  # probability from which "no gap" is said without doubt, and from which what else it may be is named
_RECOVERED = "; recovered "  # stands in what reading says of a damaged recording
_LEFT = 2.0  # floors from which a signal that is left off is named beside "no gap"


@dataclass(frozen=True)
class BesideReport:
    """What a verdict's sentence needs beside the report.

    Attributes:
        unseen: effects that no signal would have shown, or not at a moderate size.
        reading: signal that errs where something unknown lies in a reading; empty where it does not.
        at_best: floors by which signals of held-out data are off where what is open of the rig is at its best for them; None: not known.
        asked_for: parameters that have to move for that; empty where it makes little difference.
        pressed: parameters that a fit pressed against the end of their tolerance. commissioned: see `Effect.happens`.
        since: effects in whose place a parameter stands that only the field recordings show, each with that parameter and its value.
        together: probability of the leading set with all that it cannot be told from.
        cut: tolerances within which parameters are fitted, infinite where nothing holds them.
        amplified: signals that small flaws of the model move far.
    """

    unseen: Sequence[str] = ()
    reading: str = ""
    at_best: Mapping[str, float] | None = None
    asked_for: str = ""
    pressed: Sequence[str] = ()
    commissioned: bool | None = None
    since: Mapping[str, str] = field(default_factory=dict)
    together: float = 0.0
    cut: float = CUT
    amplified: Collection[str] = ()


def sentence(report: Report, catalogue: Mapping[str, Effect], beside: BesideReport = BesideReport()) -> str:
    """The verdict with its confidence, for an engineer who reads nothing else: one sentence, and of no gap another on what it rests on.

    Args:
        report: sizes of gaps in it are infinite where free runs went astray. catalogue: effects that were asked about, by id.
    """
    match report["verdict"]:
        case "no_gap":
            return _no_gap(report, beside)
        case "explained":
            return _explained(report, catalogue, beside)
        case "ambiguous":
            return _ambiguous(report)
        case "unknown":
            return _unknown(report, beside.reading)
        case "insufficient":
            return f"The recordings allow no answer: {report['notes'][0]}."
        case other:
            raise ValueError(f"a verdict of the contract is needed, found {other!r}")


def tolerance(cut: float, whose: str = "its tolerance") -> str:
    """How far a fit may take parameters from the sheet, to stand behind them; empty where nothing holds them."""
    return f" within {cut:g} times {whose}" if math.isfinite(cut) else ""


def tolerances(cut: float) -> str:
    """The same of several."""
    return tolerance(cut, "their tolerances")


def careful(said: Sequence[str]) -> str:
    """The first of what is wrong with recordings, to stand before a sentence; empty where nothing is."""
    return f"Careful: {said[0]}{'' if said[0].endswith('?') else '.'} " if said else ""


def recovered(notes: Sequence[str]) -> list[str]:
    """Those of a report's notes that tell of a recording that was cut off or is damaged, so that only a part of it could be read."""
    return [note for note in notes if _RECOVERED in note]


def component_name(component: str) -> str:
    """A component in words, such as `line A`."""
    return _NAMES.get(component, component.replace("_", " "))


def signal_name(signal: str) -> str:
    """A signal in words; temperatures by their place."""
    place = signal.removeprefix(TEMPERATURE_PREFIX)
    return component_name(signal) if place == signal else f"temperature, {component_name(place)}"


def by_component(where: Sequence[Place]) -> dict[str, float]:
    """Share of each component in the report's places."""
    shares: dict[str, float] = {}
    for row in where:
        shares[row["component"]] = shares.get(row["component"], 0.0) + row["share"]
    return shares


def _no_gap(report: Report, beside: BesideReport) -> str:
    as_is, before, after = (report["gap"][name] for name in ("as_is", "before", "after"))
    none = next((h["probability"] for h in report["hypotheses"] if not h["effects"]), 0.0)
    said = "No gap" if none >= _PLAIN else "Probably no gap"
    reach = (f"explains data not used for that to {after:.1f} times the floor" if math.isfinite(after) else
             "goes astray in data not used for that")
    verdict = (f"{said}: with its parameters fitted{tolerances(beside.cut)} the twin {reach}{_another(beside)}, and that no effect acts "
               f"is {probably(none)} likely{_else(report)}.")
    rests = _rests_on(as_is, before, after, _left_off(report, beside), beside)
    return f"{verdict} {rests}" if rests else verdict


def _rests_on(as_is: float, before: float, after: float, left: str, beside: BesideReport) -> str:
    """One sentence on what "no gap" rests on, the first of these that there is; empty where nothing is worth it. Notes hold the rest."""
    if beside.since:
        return f"{BUT}{first_of(list(beside.since), 1)} may have changed since commissioning, which these recordings cannot tell."
    if left:
        return left
    if before > _CLOSED_BY * after:  # what the recordings in question show of the rig, its commissioning did not
        alone = f"{before:.1f}" if math.isfinite(before) else "it went astray"
        return f"{_unfitted(as_is)}, fitted to the commissioning recording alone {alone}."
    if named := [*_counted(beside.pressed, "parameter", "at the end of what a fit may use"),
                 *_counted(beside.unseen, "effect", "that would not show")]:
        return f"The notes name {' and '.join(named)}."
    return f"{_unfitted(as_is)}, which calibration closes." if as_is > _CLOSED_BY * after else ""


def _unfitted(as_is: float) -> str:
    return f"Unfitted the twin {f'was {as_is:.1f} times the floor off' if math.isfinite(as_is) else 'went astray'}"


def _lie(gap: float) -> str:
    return f"lie {gap:.1f} times the floor off" if math.isfinite(gap) else "go astray"


def _stays(worst: str, least: str, times: float) -> str:
    return f"{worst} stays {least}{times:.1f} times its floor off" if math.isfinite(times) else f"{worst} goes astray"


def _counted(names: Sequence[str], what: str, which: str) -> list[str]:
    """How many of these there are, in words; empty where there are none."""
    return [f"{len(names)} {what}{'s' * (len(names) > 1)} {which}"] if names else []


def _left_off(report: Report, beside: BesideReport) -> str:
    """A sentence on the signal that stays farthest off beside "no gap"; empty where none is far off."""
    worst, times = _left_most(report, beside.at_best)
    if times <= _LEFT:
        return ""
    easily = ", which small flaws of the model move far," if worst in beside.amplified else ""
    least = "" if beside.at_best is None else "at least "
    said = _stays(signal_name(worst) + easily, least, times)
    return f"{said[:1].upper()}{said[1:]}, and no listed effect explains that."


def untold(since: Mapping[str, str]) -> str:
    """That effects may act since commissioning and that nothing tells; of the first the value that stands in its place."""
    value = next(iter(since.values()))
    return f"{first_of(list(since), 1)} may have changed since commissioning, and these recordings cannot tell: {shown_by_field(value)}"


def shown_by_field(value: str) -> str:
    """Why nothing tells since when a parameter has the value that stands in an effect's place."""
    return f"the field recordings show {value}, the commissioning recording does not show it"


def _else(report: Report) -> str:
    """What else it may be where "no gap" is not sure, each with its probability; empty where nothing else counts."""
    others = [h for h in report["hypotheses"] if h["effects"] and h["probability"] >= _COUNTS]
    named = ", ".join(f"{_in_words(h['effects'])} {probably(h['probability'])}" for h in others[:_OTHERS])
    return f" ({named})" if named else ""


def _in_words(effects: Sequence[str]) -> str:
    """A set in words."""
    return "something that is not listed" if list(effects) == ["unknown"] else " + ".join(effects) or "no effect"


def _left_most(report: Report, at_best: Mapping[str, float] | None, but: Collection[str] = ()) -> tuple[str, float]:
    """The signal that stays farthest off held-out data, and by how many floors; those in ``but`` are left out."""
    off = {name: row["after"] / row["noise"] for name, row in report["shrink"].items()} if at_best is None else at_best
    left = {name: times for name, times in off.items() if name not in but}
    worst = max(left, key=left.get, default="")
    return worst, left.get(worst, 0.0)


def _explained(report: Report, catalogue: Mapping[str, Effect], beside: BesideReport) -> str:
    marginal = {row["effect"]: row["probability"] for row in report["why"]}
    leader = sorted(_leader(report), key=lambda name: -marginal.get(name, 0.0))  # what is surest first
    gap = report["gap"]
    named = [_named(report, name, catalogue, beside.commissioned) + _not_told_from(report, name, leader) for name in leader]
    text = f"The gap is explained by {' and '.join(named)}"
    worst, times = _left_most(report, beside.at_best, beside.amplified)
    least = "" if beside.at_best is None else "at least "
    left = f"; {_stays(signal_name(worst), least, times)}, which nothing that is listed explains" if times > _LEFT else ""
    without = next((h["gap_after"] for h in report["hypotheses"] if not h["effects"] and h["gap_after"] is not None), math.inf)
    if not math.isfinite(gap["before"]) or not math.isfinite(gap["after"]):
        much = f"free runs of data not used to find it {_lie(gap['after'])} with it and {_lie(gap['before'])} without it"
    elif gap["before"] <= 1.0 and gap["after"] > _HARDLY * gap["before"]:
        much = ("only the recording in which it was sought tells of it: data not used to find it lie within the floor with it and without "
                f"it ({gap['after']:.1f} and {gap['before']:.1f} times)")
    elif _HARDLY * without < gap["after"] and without < _HARDLY * gap["before"]:
        much = (f"data not used to find it lie {gap['after']:.1f} times the floor off with it and {without:.1f} times without it, once the "
                f"rig's parameters are fitted anew ({gap['before']:.1f} before), so that what tells of it is in the recording in which it "
                "was sought alone")
    elif gap["after"] < gap["before"]:
        much = f"it shrinks from {gap['before']:.1f} to {gap['after']:.1f} times the floor on data not used to find it"
        if without < _HARDLY * gap["before"]:
            much += f", where the rig's parameters fitted anew without it leave {without:.1f}"
        if gap["before"] <= BEGINS:
            much += ", where without it hardly anything is beyond the floor"
            much += "" if beside.commissioned else ", as the rig's own parameters may take up what it does"
    else:
        much = f"data not used to find it lie {gap['after']:.1f} times the floor off, {gap['before']:.1f} without it"
    return f"{text.removesuffix(',')}: {much}{_another(beside)} ({_how_sure(report, leader, marginal, beside.together)}){left}."


def _how_sure(report: Report, leader: Sequence[str], marginal: Mapping[str, float], together: float) -> str:
    """Probability of the leading set; of it and all that it cannot be told from, and of each effect, where those differ much."""
    own = _probability(report, leader)
    text = f"probability {probably(own)}"
    if together > own + _DIFFERS:
        alone = len(leader) == 1 and marginal.get(leader[0], own) > together - _DIFFERS
        text += f", {probably(together)} {'alone or beside others' if alone else 'with what it cannot be told from'}"
    if len(leader) > 1 and marginal.get(leader[0], own) > own + _DIFFERS:
        text += "; " + ", ".join(f"{name} {probably(marginal.get(name, own))}" for name in leader) + " each for itself"
    return text


def _not_told_from(report: Report, name: str, leader: Sequence[str]) -> str:
    """Other effects of the class of one that leads; empty where it has none."""
    members = dict.fromkeys(m for c in report["classes"] if name in c for m in c if m not in leader)
    return f", which this recording cannot tell from {', '.join(members)}," if members else ""


def _another(beside: BesideReport) -> str:
    """To what the gap shrinks where what only held-out data show of the rig is as they ask; empty where that makes little difference."""
    if not beside.asked_for or beside.at_best is None:
        return ""
    return (f", and {of_all(beside.at_best):.1f} times with another {beside.asked_for}, which no fitted recording shows and which "
            "tolerance allows")


def _ambiguous(report: Report) -> str:
    sets = [h for h in report["hypotheses"] if h["probability"] >= 0.05][:4]
    named = "; ".join(f"{_in_words(h['effects'])} {probably(h['probability'])}" for h in sets)
    before = report["gap"]["before"]
    if before <= BEGINS:
        return f"{_sought(before)}, and these cannot be told apart surely: {named}."
    there = f"There is a gap of {before:.1f} times the floor" if math.isfinite(before) else "Free runs of data not used for that go astray"
    return f"{there}, and these cannot be told apart surely: {named}."


def _sought(before: float) -> str:
    """That a cause is asked for where data not used to find it lie within the floor."""
    return (f"Data not used for that lie {before:.1f} times the floor off, which is no gap, but the recording in which it was sought asks "
            "for a cause")


def _unknown(report: Report, reading: str) -> str:
    unknown = report["unknown"] or {}
    which = f": {reading}" if reading else ""
    place = f" at {unknown['component']} ({unknown['domain']}{which}){_or_elsewhere(report)}" if unknown else ""
    before = report["gap"]["before"]
    fitted = next((h["gap_after"] for h in report["hypotheses"] if not h["effects"] and h["gap_after"] is not None), math.inf)
    if before > BEGINS and fitted < _HARDLY * before:  # its size is not that of what acts there
        off = (f"data not used to find it lie {before:.1f} times the floor off, and {fitted:.1f} times" if math.isfinite(before) else
               f"free runs of data not used to find it go astray, and {_lie(fitted)}")
        return f"Something acts{place} that no listed effect explains: {off} with the rig's parameters fitted anew."
    if not math.isfinite(before):
        return f"Free runs of data not used to find it go astray, and something acts{place} that no listed effect explains."
    if before <= BEGINS:
        return f"{_sought(before)}{place} that no listed effect explains."
    return f"There is a gap of {before:.1f} times the floor{place} that no listed effect explains."


def _or_elsewhere(report: Report) -> str:
    """Other components at which it may lie, with the probability of each; empty where the first is sure."""
    shares = by_component(report["where"])
    first = report["unknown"]["component"]
    others = sorted((name for name in shares if name != first), key=lambda name: -shares[name])
    if shares.get(first, 1.0) >= _SURE or not others:
        return ""
    return f", {probably(shares[first])} likely, or at " + ", ".join(f"{name} {probably(shares[name])}" for name in others[:_OTHERS]) + ","


def _leader(report: Report) -> list[str]:
    return max((h for h in report["hypotheses"] if h["effects"] and h["effects"] != ["unknown"]), key=lambda h: h["probability"])["effects"]


def _probability(report: Report, leader: Sequence[str]) -> float:
    return next(h["probability"] for h in report["hypotheses"] if set(h["effects"]) == set(leader))


def _named(report: Report, name: str, catalogue: Mapping[str, Effect], commissioned: bool | None) -> str:
    row = next((r for r in report["why"] if r["effect"] == name), {})
    parameters = row.get("parameters", {})
    values = [f"{p.replace('_', ' ')} {plus_minus(v['value'], v['std'], v['unit'])}{_usual(v)}" for p, v in parameters.items()]
    moved = sum(v["value"] - (v.get("nominal") or 0.0) for v in parameters.values())
    about = catalogue[name].happens(moved, commissioned).rstrip(".") if name in catalogue else ""
    return f"{name} ({'; '.join(values + [about[:1].lower() + about[1:]] if about else values)})"


def _usual(value: Mapping) -> str:
    """The value without the effect, where it is another than nothing."""
    usual = value.get("nominal")
    return f" instead of {plain(usual * shown(value['unit']).factor)}" if usual else ""
