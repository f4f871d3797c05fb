"""Names and what to say of them: in full; of one that is none the nearest that is, where one is near; of many the first few."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

_NEAR = 0.4
"""Share of letters in common, as difflib counts it, from which one name may have been meant for another."""


def in_namespace(namespace: str, name: str) -> str:
    """A name in full, with its namespace (`/`, `/rig_1`, or one with a slash at its end); as it is where it is in full already."""
    return name if name.startswith("/") else f"{namespace.rstrip('/')}/{name}"


def nearest(given: object, valid: Iterable[str]) -> str:
    """`; the nearest is '...'`, '' where no valid name is near."""
    near = difflib.get_close_matches(str(given), list(valid), n=1, cutoff=_NEAR)
    return f"; the nearest is {near[0]!r}" if near else ""


def no_such(kind: str, given: object, valid: Iterable[str]) -> str:
    """That there is none of a kind by that name, the nearest, and all that are valid."""
    valid = list(valid)
    near = nearest(given, valid)
    return f"no {kind} {given!r}{near}{',' if near else ';'} valid are {', '.join(valid)}"


def first_of(names: Sequence[str], most: int) -> str:
    """The first of names, so many at most, and how many more; '' where there are none."""
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
