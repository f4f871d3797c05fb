"""A study of one real rig: what was asked, on which data, what came of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.real_rigs.diagnose import Outcome


class RecordingsError(ValueError):
    """Recordings of a rig that are missing or cannot be used; one line that says where a user gets them."""


@dataclass(frozen=True)
class Row:
    """One figure before and after the effects that were found.

    Attributes:
        what: such as ``relative force error``. unit: as people read it. split: on which data, such as ``pulse record, held out``.
        samples: how many. before, after: without and with the effects. before_interval, after_interval: 95 %, None where not known.
        published: what others report, empty where there is nothing.
    """

    what: str
    unit: str
    split: str
    samples: int
    before: float
    after: float
    before_interval: tuple[float, float] | None = None
    after_interval: tuple[float, float] | None = None
    published: str = ""


@dataclass(frozen=True)
class Control:
    """A negative control: what was tried, what must come out, what came out.

    Attributes:
        expected, found: in words. passed: whether the one is the other.
    """

    what: str
    expected: str
    found: str
    passed: bool


@dataclass(frozen=True)
class Line:
    """A line of a picture: label, role (`report.page.charts.ROLES`), values (n,); ``dots`` draws samples."""

    label: str
    role: str
    values: np.ndarray
    dots: bool = False


@dataclass(frozen=True)
class Picture:
    """Lines over time (s, (n,)), and differences of pairs of them below: (line, reference)."""

    title: str
    unit: str
    time: np.ndarray
    lines: Sequence[Line]
    differences: Sequence[tuple[int, int]] = ()
    note: str = ""


@dataclass(frozen=True)
class Study:
    """What came of a rig's recordings.

    Attributes:
        rig: name of the package. title: of the rig. source: who measured, where a user gets the recordings.
        splits: (name, which data) in the order of use. sentence: how it came out, one sentence.
        found: effects that were built in. rounds: diagnoses in their order, each with the effects before it built in.
        rows: figures before and after. controls: negative controls. pictures: of held-out data.
        tables: further tables, title to rows of cells, the first row the headings. files: name to text, written beside the report.
        assumptions, notes: texts. seconds: by stage.
    """

    rig: str
    title: str
    source: str
    splits: Sequence[tuple[str, str]]
    sentence: str
    found: Sequence[str]
    rounds: Sequence[Outcome]
    rows: Sequence[Row]
    controls: Sequence[Control]
    pictures: Sequence[Picture] = ()
    tables: Mapping[str, Sequence[Sequence[object]]] = field(default_factory=dict)
    files: Mapping[str, str] = field(default_factory=dict)
    assumptions: Sequence[str] = ()
    notes: Sequence[str] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)

    def as_json(self) -> dict:
        """Everything but pictures and files, for JSON."""
        rows = [{"what": r.what, "unit": r.unit, "split": r.split, "samples": r.samples, "before": r.before, "after": r.after,
                 "before_interval": r.before_interval, "after_interval": r.after_interval, "published": r.published} for r in self.rows]
        controls = [{"what": c.what, "expected": c.expected, "found": c.found, "passed": c.passed} for c in self.controls]
        return {"rig": self.rig, "title": self.title, "source": self.source, "splits": dict(self.splits), "sentence": self.sentence,
                "rounds": [one.as_json() for one in self.rounds], "found": list(self.found), "rows": rows, "controls": controls,
                "tables": {name: [list(row) for row in rows] for name, rows in self.tables.items()}, "files": sorted(self.files),
                "notes": list(self.notes), "seconds": dict(self.seconds)}
