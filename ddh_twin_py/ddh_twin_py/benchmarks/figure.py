"""One measured number beside what it is held against."""

from __future__ import annotations

from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Figure:
    """One measured number.

    `against` is a limit of this project or another tool's figure (None: there is none), `source`
    says which: "limit" is the project's own, "aim" too; a tool named with "here" was timed in the same
    run, others on another machine of 2 cores. The ratio is above 1 where the value is better;
    `smaller` tells which way that is.
    """

    name: str
    value: float
    unit: str
    against: float | None
    source: str = ""
    smaller: bool = True

    @property
    def ratio(self) -> float | None:
        """How many times better than what it is held against."""
        if self.against is None or not self.value or not self.against:
            return None
        return self.against / self.value if self.smaller else self.value / self.against

    def row(self) -> dict:
        """As written to the JSON file."""
        return {key: value for key, value in asdict(self).items() if key != "smaller"} | {"ratio": self.ratio}

    def cells(self) -> tuple[str, ...]:
        """As printed."""
        return (
            self.name, f"{_short(self.value)} {self.unit}", "" if self.against is None else _short(self.against),
            "" if self.ratio is None else _short(self.ratio), self.source,
        )


def _short(value: float) -> str:
    if value == 0 or abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}"
