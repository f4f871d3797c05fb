"""One line of a fleet's table, from a recording and what its diagnosis says."""

from __future__ import annotations

import csv
import io
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime

from ddh_twin_py.bags.case import Case
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.diagnosis.process import Outcome
from ddh_twin_py.gap.contract import Report, Why
from ddh_twin_py.gap.words import careful, recovered

COPY = " | "
"""Between names in `Row.copies`."""


@dataclass(frozen=True)
class Row:
    """One recording.

    Attributes:
        recording: path below the folder. rig: as announced in the bag. begin: UTC of the first sample, ISO 8601. duration: s.
        verdict: by the contract's schema. effect: the most probable one; members of its class joined by " | ".
        also: what acts beside it in the most probable set, joined by " + ".
        probability: of the effect, or of the class together. size, size_std, nominal: of the effect's parameter, in `unit`.
        gap_before, gap_after: in multiples of the noise floor. error: in one line, '' where there is a report.
        version: of this project, as it answered; '' where the answer is older than that it is kept.
        copies: paths of other recordings with the same content, joined by `COPY`.
        sheet: what it was held against, `Found.sheet`; '' where there is no answer.
    """

    recording: str
    rig: str = ""
    begin: str = ""
    duration: float | None = None
    verdict: str = ""
    effect: str = ""
    also: str = ""
    probability: float | None = None
    parameter: str = ""
    size: float | None = None
    size_std: float | None = None
    unit: str = ""
    nominal: float | None = None
    gap_before: float | None = None
    gap_after: float | None = None
    sentence: str = ""
    error: str = ""
    version: str = ""
    copies: str = ""
    sheet: str = ""

    @property
    def time(self) -> datetime | None:
        """`begin` as a time, None where it is not known."""
        return datetime.fromisoformat(self.begin) if self.begin else None

    @property
    def names(self) -> str:
        """Its path, and those of its copies."""
        return " = ".join([self.recording, *filter(None, self.copies.split(COPY))])


COLUMNS = tuple(f.name for f in fields(Row))
_FORMULA = ("=", "+", "-", "@")
_OF_THE_SET = re.compile(r" \(probability [^()]*\)")
NUMBERS = tuple(f.name for f in fields(Row) if "float" in str(f.type))


def kept_row(kept: Mapping) -> Row:
    """A row as a file keeps it. Raises TypeError or ValueError where a value is of another type, no finite number, or no time in UTC."""
    row = Row(**kept)
    for name, value in asdict(row).items():
        number = type(value) in (int, float) and abs(value) <= sys.float_info.max
        if not (number or value is None if name in NUMBERS else isinstance(value, str)):
            raise TypeError(f"{name} is {value!r}")
    if row.time is not None and row.time.tzinfo is None:
        raise ValueError(f"begin is {row.begin!r}")
    return row


def facts(name: str, case: Case) -> dict:
    """Rig, begin and duration of the first field recording, as fields of `Row`. Raises BagError."""
    recording = read_recording(case.field[0])
    begin = datetime.fromtimestamp(round(recording.epoch_ns * 1e-9 + recording.span[0]), UTC)
    return {
        "recording": name, "rig": recording.rig.rig_id if recording.rig else "", "begin": f"{begin:%Y-%m-%dT%H:%M:%SZ}",
        "duration": round(recording.duration, 3),
    }  # fmt: skip


def with_one_probability(row: Row) -> Row:
    """The same, its sentence without the probability of all that acts together, where `probability` tells that of the effect: it is another
    number."""
    return row if row.probability is None else replace(row, sentence=_OF_THE_SET.sub("", row.sentence))


def row_of(known: dict, outcome: Outcome) -> Row:
    """The row of a recording whose facts are known."""
    if outcome.error:
        return Row(**known, error=outcome.error)
    report = outcome.report
    gap = report.get("gap") or {}
    row = {
        **known, "verdict": report.get("verdict", ""), "gap_before": gap.get("before"), "gap_after": gap.get("after"),
        "sentence": _damage_first(outcome),
    }  # fmt: skip
    why = report.get("why") or []
    if row["verdict"] in ("explained", "ambiguous", "unknown") and why:
        row |= _effect(why, report.get("classes") or [], _leading(report))
    return Row(**row)


def _damage_first(outcome: Outcome) -> str:
    """The sentence, with what reading lost of a recording before all else that it is careful of."""
    lost = [note for note in recovered(outcome.report.get("notes") or []) if note not in outcome.sentence]
    return f"{careful(lost)}{outcome.sentence.removeprefix('Careful: ') if lost else outcome.sentence}"


def _leading(report: Report) -> list[str]:
    """The most probable set of effects, empty where none is named."""
    sets = [h for h in report.get("hypotheses") or [] if h["effects"]]
    return max(sets, key=lambda h: h["probability"])["effects"] if sets else []


def _effect(why: Sequence[Why], classes: Sequence[Sequence[str]], leading: Sequence[str]) -> dict:
    first = why[0]
    members = next((list(c) for c in classes if first["effect"] in c), [first["effect"]])
    shares = {entry["effect"]: entry["probability"] for entry in why}
    together = sum(shares.get(member, 0.0) for member in members)
    also = [name for name in leading if name not in members] if set(leading) & set(members) else []
    found = {"effect": " | ".join(members), "also": " + ".join(also), "probability": min(1.0, together)}
    for name, value in (first.get("parameters") or {}).items():
        size = {"parameter": name, "size": value["value"], "size_std": value["std"], "unit": value["unit"], "nominal": value.get("nominal")}
        return found | size
    return found


def as_csv(rows: Sequence[Row]) -> str:
    """A header and one line for each row; numbers as they are, nothing where there is none, a text that a spreadsheet would take
    for a formula behind an apostrophe."""
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({key: _cell(value) for key, value in asdict(row).items()})
    return out.getvalue()


def _cell(value: str | float | None) -> str | float:
    if value is None:
        return ""
    return f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value
