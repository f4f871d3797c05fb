"""Names and what to say of them: in full; of one that is none the nearest that is, where one is near; of many the first few; what was
given, cut where it is long."""

from __future__ import annotations

import difflib
import reprlib
from collections.abc import Iterable, Sequence

_LONGEST, _LONGEST_LINE = 60, 4000
"""Characters of a value that are shown, and of a line that says what is wrong."""
_NEAR = 0.4
"""Share of letters in common, as difflib counts it, from which one name may have been meant for another."""

_CITED = reprlib.Repr(maxlevel=3)


def in_namespace(namespace: str, name: str) -> str:
    """A name in full, with its namespace (`/`, `/rig_1`, or one with a slash at its end); as it is where it is in full already."""
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def nearest(given: object, valid: Iterable[str]) -> str:
    """`; the nearest is '...'`, '' where no valid name is near."""
    near = difflib.get_close_matches(str(given)[:_LONGEST], list(valid), n=1, cutoff=_NEAR)
    return f"; the nearest is {near[0]!r}" if near else ""


def no_such(kind: str, given: object, valid: Iterable[str]) -> str:
    """That there is none of a kind by that name, the nearest, and all that are valid."""
    valid = list(valid)
    near = nearest(given, valid)
    return f"no {kind} {cited(given)}{near}{',' if near else ';'} valid are {', '.join(valid)}"


def cited(value: object, longest: int = _LONGEST) -> str:
    """A value as Python writes it, its begin where that is longer than so many characters."""
    if isinstance(value, str):
        value = value[: longest + 1]
    try:
        text = _CITED.repr(value) if isinstance(value, (list, tuple, dict, set)) else repr(value)
    except ValueError:  # Python writes no such number
        return "a number of thousands of digits"
    return text if len(text) <= longest else f"{text[: longest - 3]}..."


def short(line: str) -> str:
    """A line that says what is wrong, without its middle where what was given made it longer than anybody reads."""
    return line if len(line) <= _LONGEST_LINE else f"{line[: _LONGEST_LINE // 2]} ... {line[-_LONGEST_LINE // 2 :]}"


def first_of(names: Sequence[str], most: int) -> str:
    """The first of names, so many at most, and how many more; '' where there are none."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
