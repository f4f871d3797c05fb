"""One thing that was looked at: what was found, what is right, what to do."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass

LEVELS = ("ok", "note", "warning", "error")
"""ok: as it should be; note: worth knowing; warning: works, but not as well as it could; error: does not work."""


@dataclass(frozen=True)
class Check:
    """One judgement.

    `group`: installation, middleware, clock, machine or twin. `found`: with its unit. `right`: what is allowed, '' where nothing
    else could be. `advice`: what to do, '' where all is well.
    """

    group: str
    name: str
    level: str
    found: str
    right: str = ""
    advice: str = ""

    def __post_init__(self) -> None:
        if self.level not in LEVELS:
            raise ValueError(f"{self.level!r} is no level; valid are {', '.join(LEVELS)}")


def worst(checks: Iterable[Check]) -> str:
    """The worst level, `ok` where there is none."""
    return max((check.level for check in checks), key=LEVELS.index, default="ok")


def as_json(checks: Iterable[Check]) -> dict:
    """Verdict, counts and all checks as plain data."""
    several = list(checks)
    return {
        "worst": worst(several),
        "counts": {level: sum(check.level == level for check in several) for level in LEVELS},
        "checks": [asdict(check) for check in several],
    }
