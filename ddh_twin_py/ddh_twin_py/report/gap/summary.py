"""The short summary of a gap diagnosis for a terminal; the same numbers as its page."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from rich.console import Console
from rich.text import Text

from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.shrink.size import WITHOUT_COMMISSIONING
from ddh_twin_py.gap.words import recovered
from ddh_twin_py.report.gap.words import (
    NEAR,
    VERDICTS,
    capital,
    closed,
    component_name,
    effect_name,
    ending,
    farther_off,
    floors,
    percent,
    places,
    set_name,
    signal_name,
    times_floor,
)
from ddh_twin_py.report.replay.summary import STYLE
from ddh_twin_py.report.units import in_unit, number, plus_minus, probably, words

if TYPE_CHECKING:
    from ddh_twin_py.gap.contract import Report
    from ddh_twin_py.gap.diagnosis import Diagnosis, Weighed

LINES, WIDTH = 25, 80
"""What a summary fits in on a terminal that is not wider."""
_ENDLESS, _NARROW = 10_000, 60  # columns of a file, of the narrowest terminal that is looked after
_MOST_HYPOTHESES, _MOST_PLACES, _MOST_SIGNALS, _MOST_LOST = 4, 3, 5, 2
_LEAST_OF_SENTENCE, _MORE_OF_SENTENCE = 4, 3  # lines
_MOST_OF_TEST, _LEAST_OF_SIGNALS, _LEAST_OF_NOTES = 7, 4, 2  # lines
_MOST_OF_ENDS = 2  # lines on the signals that stay off their floor
_LEAST_OF_REST = 2  # lines: a place and the signals
_INDENT = 21  # columns before the words of what has a share
_FURTHER = "further notes"
SPREAD = "± is one standard deviation"
"""What stands once below the causes, where a line is left."""


def gap_summary(diagnosis: Diagnosis, width: int = WIDTH) -> list[Text]:
    """Verdict, gap, causes, places, signals, next test: at most `LINES` lines of ``width`` columns."""
    report = diagnosis.report
    words, level = VERDICTS[report["verdict"]]
    gap, causes = _gap(diagnosis, width), _hypotheses(diagnosis, width, 2)
    test = _titled("next test", report["next_test"]["description"], _MOST_OF_TEST, width) if report["next_test"] else []
    sentence = _sentence(words, diagnosis.sentence)
    lines, missing, lost = _begin(diagnosis, sentence, _LEAST_OF_SENTENCE, width)
    least = LINES - _LEAST_OF_REST - _LEAST_OF_SIGNALS
    spread = _titled("", SPREAD, 1, width) if "±" in _plain([*lines, *causes, *_places(report, width)]) else []
    if sum(map(len, (lines, missing, gap, causes, spread, test))) > least:
        causes = _hypotheses(diagnosis, width, 1)
    causes += spread if sum(map(len, (lines, missing, gap, causes, spread, test))) <= least else []
    spare = least - sum(map(len, (lines, missing, gap, causes, test)))
    if spare > 0:
        lines, missing, lost = _begin(diagnosis, sentence, _LEAST_OF_SENTENCE + min(spare, _MORE_OF_SENTENCE), width)
    lines[0].stylize(f"bold {STYLE[level]}", 0, len(words))
    notes = [note for note in report["notes"] if note not in lost and note not in _plain(lines)]
    lines += missing
    room = LINES - sum(map(len, (lines, gap, causes, test))) - _LEAST_OF_REST
    lines += [*gap, *(_floor(diagnosis, width) if gap and room > 0 else []), *causes]
    lines += _places(report, width)[: max(1, LINES - len(lines) - len(test) - _LEAST_OF_SIGNALS)]
    lines += _signals(report, LINES - len(lines) - len(test) - min(len(notes), _LEAST_OF_NOTES), width)
    lines += test
    return (lines + _notes(notes, LINES - len(lines), width))[:LINES]


def _sentence(words: str, said: str) -> str:
    """The verdict's words and the sentence, which does not repeat them; what to be careful of is a sentence of its own."""
    if said.startswith(f"Probably {words.lower()}: "):
        return said
    rest = "".join(map(capital, said.partition(f"{words}: ")[::2]))
    return f"{words}{'.' if said.startswith('Careful: ') else ':'} {rest}"


def _begin(diagnosis: Diagnosis, sentence: str, most: int, width: int) -> tuple[list[Text], list[Text], list[str]]:
    """The sentence in at most so many lines, lines on data that were lost and that these do not name, and the notes that they say.

    Data on which a diagnosis rests come first.
    """
    lines = [Text(line) for line in _wrapped(sentence, most, width)]
    lost = [note for note in lost_data(diagnosis) if note not in _plain(lines)][:_MOST_LOST]
    return lines, [line for i, note in enumerate(lost) for line in _titled("" if i else "data", note, 3, width)], lost


def lost_data(diagnosis: Diagnosis) -> list[str]:
    """What is wrong with the recordings so far that data are lost by it."""
    return list(dict.fromkeys([*diagnosis.damage, *recovered(diagnosis.report["notes"])]))


def _plain(lines: list[Text]) -> str:
    return " ".join(line.plain for line in lines)


def print_gap(diagnosis: Diagnosis, console: Console | None = None) -> None:
    """Print the summary: as wide as the terminal; where it goes to a file in lines as long as they have to be, so that nothing is cut."""
    console = console or Console()
    if console.is_terminal:
        for line in gap_summary(diagnosis, max(_NARROW, console.width)):
            console.print(line, no_wrap=True, overflow="ellipsis", highlight=False)
        return
    lines = gap_summary(diagnosis)
    if any(mark in line.plain for line in lines for mark in ("…", _FURTHER)):
        lines = gap_summary(diagnosis, _ENDLESS)
    for line in lines:
        console.print(line, soft_wrap=True, highlight=False)


def _gap(diagnosis: Diagnosis, width: int) -> list[Text]:
    report, gap = diagnosis.report, diagnosis.report["gap"]
    if report["verdict"] == "insufficient":
        return []
    fraction = gap["closed_fraction"]
    said = "" if fraction is None else f" ({closed(fraction)} closed from {floors(gap['before'], '')})"
    last = f"{ending(report['verdict'], diagnosis.added)}{said}"
    return _titled("gap", f"{floors(gap['as_is'], ' × floor')} unfitted, {floors(gap['before'], '')} fitted, "
                          f"{floors(gap['after'], '')} {last}", 2, width)


def _floor(diagnosis: Diagnosis, width: int) -> list[Text]:
    """What the gap is a multiple of."""
    built = bool(diagnosis.recordings.get("commissioning"))
    return _titled("", "floor: what a fitted twin misses of the rig as built, at least noise" if built else
                   f"floor: {WITHOUT_COMMISSIONING:g} times the sensors' noise; the rig as built is not recorded", 1, width)


def _hypotheses(diagnosis: Diagnosis, width: int, most: int) -> list[Text]:
    """The likeliest, each in ``most`` lines or less, with its values where they fit."""
    shown = [w for w in diagnosis.weighed if w.probability >= 0.005][:_MOST_HYPOTHESES]
    lines = []
    for i, w in enumerate(shown):
        fits = (way for way in _with_values(w) if len(_wrapped(way, most + 1, width - _INDENT)) <= most)
        lines += _weighed("" if i else "cause", probably(w.probability), next(fits, set_name(w.effects)), width, most)
    for members in diagnosis.report["classes"][:1]:
        lines += _titled("alike", ", ".join(effect_name(e) for e in members) + " look alike in this record", 2, width)
    return lines


def _with_values(w: Weighed) -> list[str]:
    """A set with its values, in full first and then without the names of the quantities; each value beside its effect."""
    values = {effect: plus_minus(value, std, unit) for effect, (value, std, unit, _) in w.values.items()}
    if not values:
        return []
    named = {effect: f"{words(EFFECTS[effect].parameter)} {value}" if effect in EFFECTS else value for effect, value in values.items()}
    if len(w.effects) == 1:
        return [f"{set_name(w.effects)}, {'; '.join(named.values())}", f"{set_name(w.effects)}  {'; '.join(values.values())}"]
    return [" and ".join(f"{effect_name(e)} ({told[e]})" if e in told else effect_name(e) for e in w.effects) for told in (named, values)]


def _places(report: Report, width: int) -> list[Text]:
    lines = []
    for i, place in enumerate(places(report["where"])[:_MOST_PLACES]):
        row = place.largest
        phase = "mean" if row["phase"] == "all" else row["phase"]
        most = f"{percent(row['share'])} " if place.rows > 1 else ""
        said = (f"{component_name(place.component)}: {most}{row['domain']}, {phase}, "
                f"{plus_minus(row['missing'], row['std'], row['unit'], sign=True)}")
        lines += _weighed("" if i else "where", percent(place.share), said, width, 2)
    return lines


def _signals(report: Report, room: int, width: int) -> list[Text]:
    worst = sorted(report["shrink"].items(), key=lambda item: -max(times_floor(item[1], "before"), times_floor(item[1], "after")))
    rows = [item for item in worst if max(times_floor(item[1], "before"), times_floor(item[1], "after")) > NEAR]
    if not report["shrink"]:
        return []
    if not rows:
        return [Text(f"signals    all {len(worst)} within {NEAR:g} times their noise floor")]
    lines = [Text(f"{'signals':<11}{'RMS of what the twin misses':<30}{'before → after':>19}{'× noise floor':>20}")]
    last = _how_they_end(report, max(1, min(_MOST_OF_ENDS, room - 2)), width)
    most = max(0, min(_MOST_SIGNALS, room - 1 - len(last)))
    if not most:
        return _how_they_end(report, max(1, min(_MOST_OF_ENDS, room)), width, "signals")
    for name, row in rows[:most]:
        before, after, unit = times_floor(row, "before"), times_floor(row, "after"), row["unit"]
        sizes = f"{in_unit(row['before'], unit, False)} → {in_unit(row['after'], unit)}"
        line = Text(f"{'':<11}{signal_name(name):<28}{sizes:>21}{f'{number(before, 2)} → {number(after, 2)}':>20}")
        line.truncate(width)
        if after > NEAR:
            line.stylize(STYLE["fair"], len(line) - len(number(after, 2)))
        lines.append(line)
    if len(worst) > len(rows[:most]):
        lines += last
    return lines


def _how_they_end(report: Report, most: int, width: int, title: str = "") -> list[Text]:
    """How many signals end near their floor, and which others stay how far off it, in ``most`` lines or less."""
    ends = sorted(((times_floor(row, "after"), name) for name, row in report["shrink"].items()), reverse=True)
    off = [f"{signal_name(name)} {number(times, 2)}" for times, name in ends if times > NEAR]
    farther = len(farther_off(report["shrink"]))
    said = f"{len(ends) - len(off)} of {len(ends)} " + (
        f"end within {NEAR:g} times their floor, {farther} farther off than before" if farther else
        f"signals end within {NEAR:g} times their floor")
    return _titled(title, f"{said}; not: {', '.join(off)}" if off else said, most, width)


def _notes(notes: list[str], room: int, width: int = WIDTH) -> list[Text]:
    """Notes as long as there is room, and how many more there are; what is left for the last one is its own."""
    lines: list[Text] = []
    if room < 1:
        return lines
    for i, note in enumerate(notes):
        left = room - len(lines) - (1 if i < len(notes) - 1 else 0)
        if left < 1:
            lines.append(Text(f"           and {len(notes) - i} {_FURTHER} in the report (--html FILE, --json FILE)"))
            break
        lines += _titled("" if i else "note", note, min(left, 3), width)
    return lines


def _titled(title: str, words: str, most: int, width: int) -> list[Text]:
    cut = _wrapped(words, most, width - 11)
    return [Text(f"{title:<11}{cut[0]}"), *(Text(" " * 11 + line) for line in cut[1:])]


def _weighed(title: str, share: str, words: str, width: int, most: int) -> list[Text]:
    """A share and what it is of."""
    cut = _wrapped(words, most, width - _INDENT)
    return [Text(f"{title:<11}{share:>8}  {cut[0]}"), *(Text(" " * _INDENT + line) for line in cut[1:])]


def _wrapped(words: str, most: int, width: int) -> list[str]:
    whole = words.replace(" ± ", "\N{NO-BREAK SPACE}±\N{NO-BREAK SPACE}")
    cut = textwrap.wrap(whole, width, max_lines=most, placeholder=" …") or [""]
    return [line.replace("\N{NO-BREAK SPACE}", " ") for line in cut]
