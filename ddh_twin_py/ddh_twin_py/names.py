"""What to say of a name that is none: the nearest that is, where one is near."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_NEAR = 0.4
"""Share of letters in common, as difflib counts it, from which one name may have been meant for another."""


def nearest(given: object, valid: Iterable[str]) -> str:
    """`; the nearest is '...'`, '' where no valid name is near."""
    near = difflib.get_close_matches(str(given), list(valid), n=1, cutoff=_NEAR)
    return f"; the nearest is {near[0]!r}" if near else ""


def no_such(kind: str, given: object, valid: Iterable[str]) -> str:
    """That there is none of a kind by that name, the nearest, and all that are valid."""
    valid = list(valid)
    near = nearest(given, valid)
    return f"no {kind} {given!r}{near}{',' if near else ';'} valid are {', '.join(valid)}"
