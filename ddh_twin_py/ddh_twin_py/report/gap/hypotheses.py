"""Why a twin and a rig part: hypotheses ranked, with what speaks for and against each."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ddh_twin_py.gap.contract import Why
from ddh_twin_py.gap.diagnosis import Diagnosis, Weighed
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.verdict.unknown import UNLISTED
from ddh_twin_py.gap.words import tolerances
from ddh_twin_py.names import first_of
from ddh_twin_py.report.gap.symbols import legend
from ddh_twin_py.report.gap.words import (
    NEAR,
    UNKNOWN,
    capital,
    effect_name,
    floors,
    leaning,
    percent,
    set_name,
    signal_name,
    strength,
)
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.safety import BEFORE, SAFETY
from ddh_twin_py.report.units import number, plus_minus, probably, words

_NOTICEABLE = 0.01
"""Probability from which on a hypothesis is shown unfolded."""
_MOST_OPEN = 4
_SAME = 0.02
"""By which the probability of an effect alone or beside others must be larger than alone to be told as another number."""
_MOST_NAMED = 3
_HIDING = "What it lacks to certainty is mostly left to causes that these recordings would hardly show; the less they would, the more."
EVIDENCE = (
    "Evidence is how much of the misfit goes away with the hypothesis: each sample's misfit in multiples of what noise allows, squared and "
    "summed (a chi-square). Up to 4 is chance; from 4 on some, from 10 clear, from 100 strong, from 1000 very strong, from 10 000 "
    "overwhelming; below 0 the signal fits worse with it. "
    "Left is what remains of the signal with it, in multiples of its noise floor. Evidence is of the recordings in which "
    "the cause was sought, what is left of those held out: a signal may fit a little worse in the one and better in the other."
)


def hypotheses(diagnosis: Diagnosis) -> doc.Html:
    """The hypotheses, most probable first, those below 1 % folded away."""
    weighed = diagnosis.weighed
    if not weighed:
        return doc.paragraph("No hypothesis could be weighed with this record.")
    count = min(_MOST_OPEN, max(1, sum(w.probability >= _NOTICEABLE for w in weighed)))
    leading, rest = weighed[:count], weighed[count:]
    blocks = [
        doc.paragraph("Each hypothesis is an effect of the catalogue, or two together, added to the twin. Its probability weighs how much "
                      "better the twin then agrees against how freely the hypothesis could have been chosen; all of them, those below "
                      "1 % that are not listed too, sum to 100 %."),
        *(_card(w, i, diagnosis, _always_left(weighed)) for i, w in enumerate(leading, 1)),
    ]
    if any(known.check for w in leading for e in w.effects if (known := diagnosis.catalogue.get(e)) is not None):
        blocks.append(doc.note(f"{BEFORE} {SAFETY}"))
    if rest:
        columns = (doc.Column("Hypothesis", number=False), doc.Column("Probability"), doc.Column("Gap left", "× floor"),
                   doc.Column("Value", number=False))
        left = ["–" if w.gap_after is None else floors(w.gap_after, "") for w in rest]
        rows = [(capital(set_name(w.effects)), probably(w.probability), gap, _values(w)) for w, gap in zip(rest, left, strict=True)]
        none = [row for w, row in zip(rest, rows, strict=True) if not w.effects]
        others = [row for w, row in zip(rest, rows, strict=True) if w.effects]
        if none:
            blocks.append(_wrapped(doc.table(columns, none, "Against which all others are weighed")))
        if others:
            said = "One further hypothesis, less probable" if len(others) == 1 else f"{len(others)} further hypotheses, less probable"
            blocks.append(doc.details(said, _wrapped(doc.table(columns, others))))
    return doc.Html("".join(blocks))


def effects_ranked(diagnosis: Diagnosis) -> doc.Html:
    """Probability of every effect, alone or beside others, as bars; nothing where it is that of the effect alone, which has its card."""
    why = diagnosis.report["why"]
    alone = {w.effects: w.probability for w in diagnosis.weighed}
    if all(row["probability"] - alone.get((row["effect"],), 0.0) < _SAME for row in why):
        return doc.Html("")
    rows = [
        (capital(effect_name(row["effect"])), _bar(row["probability"], f"{probably(row['probability'])}{_parameters(row)}")) for row in why
    ]
    body = "".join(f"<dt>{doc.text(name)}</dt><dd>{bar}</dd>" for name, bar in rows)
    return doc.Html(
        doc.note("Of each effect, alone or beside others: the sum over all hypotheses that hold it, so at least what it has alone above.")
        + f'<dl class="bars">{body}</dl>'
    )


def classes(diagnosis: Diagnosis) -> doc.Html:
    """Effects that the record cannot tell apart, with the reason for each."""
    probability = {row["effect"]: row["probability"] for row in diagnosis.report["why"]}
    blocks = []
    for members in diagnosis.report["classes"]:
        rows = [
            (capital(effect_name(e)), probably(probability[e]) if e in probability else "–",
             diagnosis.confusable.get(e, "its signals are those of the others within the noise"))
            for e in members
        ]
        columns = (doc.Column("Cannot be told apart here", number=False), doc.Column("Probability", "alone or beside others"),
                   doc.Column("Why not", number=False))
        blocks.append(_wrapped(doc.table(columns, rows)))
    return doc.Html("".join(blocks))


def _always_left(weighed: Sequence[Weighed]) -> str:
    """That the unknown has what is always left to it where an effect leads; empty where it does not stem from that."""
    named = max((w for w in weighed if w.effects != (UNKNOWN,)), key=lambda w: w.probability, default=None)
    unknown = next((w.probability for w in weighed if w.effects == (UNKNOWN,)), 0.0)
    if named is None or not named.effects or abs(unknown - UNLISTED) > 0.005:
        return ""
    return f"Where an effect leads, {probably(UNLISTED)} is always left to such a cause; nothing in this record asks for more."


def _card(w: Weighed, place: int, diagnosis: Diagnosis, left: str) -> doc.Html:
    commissioned = bool(diagnosis.recordings.get("commissioning"))
    title = set_name(w.effects)
    blocks = [
        f'<div class="cause"><h3>{place}. {doc.text(capital(title))}</h3><dl class="bars"><dt>Probability</dt>'
        f"<dd>{_bar(w.probability, probably(w.probability))}</dd></dl>"
    ]
    for effect in w.effects:
        blocks.append(_effect(effect, w, diagnosis.catalogue.get(effect), commissioned))
    if not w.effects:
        hiding = f" {_HIDING}" if diagnosis.report["verdict"] == "no_gap" else ""
        blocks.append(doc.paragraph(f"{_explained_by_none(w, diagnosis.cut)}{hiding}"))
    if w.effects == (UNKNOWN,):
        blocks.append(doc.paragraph(f"Something acts on the rig that is real and that no effect of the catalogue explains. {left}".strip()))
    if w.gap_after is not None:
        blocks.append(doc.paragraph(f"With it the gap is {number(w.gap_after, 2)} times the noise floor." if math.isfinite(w.gap_after)
                                    else "With it free runs of held-out data go astray."))
    blocks += [_in_words(w), _evidence(w, folded=place > 1), "</div>"]
    return doc.Html("".join(blocks))


def _explained_by_none(w: Weighed, cut: float) -> str:
    """What is recorded without any effect, and which signals that leaves open."""
    said = f"The rig's parameters fitted{tolerances(cut)}, the sensors' zero errors and noise explain what was recorded"
    off = [(name, times) for name, times in _sorted(w.left) if times > NEAR]
    if not off:
        return f"{said}."
    named = first_of([f"{signal_name(name)} {_times(times)}" for name, times in off], _MOST_NAMED)
    return f"{said}, all but {len(off)} of {len(w.left)} signals, which it leaves open: {named}."


def _effect(effect: str, w: Weighed, known: Effect | None, commissioned: bool) -> doc.Html:
    blocks, moved = [], 0.0
    if effect in w.values:
        value, std, unit, nominal = w.values[effect]
        moved = value - (nominal or 0.0)
        against = "" if nominal is None else f" (without the effect {plus_minus(nominal, None, unit)})"
        name = words(known.parameter) if known else effect_name(effect)
        name = f"{effect_name(effect)}, {name}" if known and len(w.effects) > 1 else name
        blocks.append(f'<p class="found">{doc.text(capital(name))}: <strong>{doc.text(plus_minus(value, std, unit))}</strong>'
                      f"{doc.text(against)}</p>")
    if known is not None:
        blocks.append(doc.paragraph(known.happens(moved, commissioned)))
        alike = ", ".join(effect_name(e) for e in known.confused_with)
        rows = (("Law", known.law), ("Symbols", legend(known.law)), ("What it shows", known.signature), ("Often taken for", alike),
                ("How to check on the machine", known.check))
        blocks.append('<dl class="about">' + "".join(f"<dt>{name}</dt><dd>{doc.text(said)}</dd>" for name, said in rows if said) + "</dl>")
    return doc.Html("".join(blocks))


def _values(w: Weighed) -> str:
    """The values, each with its effect where there are several."""
    said = {effect: plus_minus(value, std, unit) for effect, (value, std, unit, _) in w.values.items()}
    return "; ".join(f"{effect_name(effect)} {value}" if len(w.effects) > 1 else value for effect, value in said.items())


def _parameters(row: Why) -> str:
    found = [plus_minus(p["value"], p["std"], p["unit"]) for p in row.get("parameters", {}).values()]
    return f", {'; '.join(found)}" if found else ""


def _in_words(w: Weighed) -> doc.Html:
    if not any(w.gains.values()):
        return doc.Html("")
    total = sum(g for g in w.gains.values() if g > 0.0) or 1.0
    speaking = sorted(w.gains.items(), key=lambda item: -item[1])
    backing = [f"{signal_name(n)} ({strength(g)}, {percent(g / total)} of the evidence)" for n, g in speaking if g >= 4.0][:_MOST_NAMED]
    against = [f"{signal_name(n)} fits worse ({strength(g)})" for n, g in reversed(speaking) if g <= -4.0][:_MOST_NAMED]
    open_ = [f"{signal_name(n)} stays {_times(v)}" for n, v in _sorted(w.left) if v > NEAR][:_MOST_NAMED]
    rows = [("For it", "; ".join(backing) or "no signal speaks for it beyond chance"),
            ("Against it", "; ".join(against) or "no signal speaks against it beyond chance"),
            ("Left open by it", "; ".join(open_) or "no signal stays beyond its floor")]
    return doc.Html('<dl class="about">' + "".join(f"<dt>{name}</dt><dd>{doc.text(said)}</dd>" for name, said in rows) + "</dl>")


def _times(left: float) -> str:
    return f"{number(left, 1)} times its floor" if math.isfinite(left) else "astray"


def _sorted(left) -> list[tuple[str, float]]:
    return sorted(left.items(), key=lambda item: -item[1])


def _evidence(w: Weighed, folded: bool) -> doc.Html:
    names = sorted({*w.gains, *w.left}, key=lambda n: -abs(w.gains.get(n, 0.0)))
    if not any(w.gains.values()):
        return doc.Html("")
    largest = max((abs(g) for g in w.gains.values()), default=0.0) or 1.0
    columns = (doc.Column("Signal", number=False), doc.Column("Evidence", number=False), doc.Column("In words", number=False),
               doc.Column("Left", "× floor", number=False))
    rows = []
    for name in names:
        gain, left = w.gains.get(name), w.left.get(name)
        bar = doc.Html("–") if gain is None else _signed(gain, largest)
        mark = doc.Html("–") if left is None else doc.mark("good" if left <= NEAR else "fair" if left <= 2.0 else "poor", floors(left, ""))
        rows.append((signal_name(name), bar, "–" if gain is None else leaning(gain), mark))
    caption = "Evidence signal by signal"
    if folded:
        return doc.details(caption, _snug(doc.table(columns, rows)), doc.note(EVIDENCE))
    return doc.Html(_snug(doc.table(columns, rows, caption)) + doc.note(EVIDENCE))


def _bar(share: float, words: str) -> str:
    width = min(max(share, 0.0), 1.0)
    return (f'<div class="bar"><i style="width:calc((100% - 14em) * {width:.4f});background:var(--accent)"></i>'
            f"<span>{doc.text(words)}</span></div>")


def _signed(gain: float, largest: float) -> doc.Html:
    """A bar to the right of a middle line for what speaks for it, to the left for what speaks against it."""
    side = "for" if gain >= 0.0 else "against"
    bar = f'<i class="{side}" style="width:{100.0 * min(1.0, abs(gain) / largest):.1f}%"></i>'
    return doc.Html(f'<div class="signed">{bar}<span>{doc.text(number(gain, 0 if abs(gain) >= 100.0 else 1))}</span></div>')


def _snug(table: doc.Html) -> doc.Html:
    return doc.Html(f'<div class="snug">{table}</div>')


def _wrapped(table: doc.Html) -> doc.Html:
    return doc.Html(f'<div class="wrap-first">{table}</div>')


def between(effects: Sequence[str]) -> str:
    """Effects or sets of them (joined by ` + `) that a test tells apart, in words."""
    first, *others = [" and ".join(effect_name(e) for e in one.split(" + ")) for one in effects] or [""]
    listed = ", from ".join(others[:-1])
    return f"{first} from {listed and f'{listed} and from '}{others[-1]}" if others else first
