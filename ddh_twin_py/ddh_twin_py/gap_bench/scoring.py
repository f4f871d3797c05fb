"""Scores of a bench: per suite and level, each with its 95 % interval and number of cases."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

from ddh_twin_py.gap_bench.aims import AIMS
from ddh_twin_py.gap_bench.answers import Answer, answer_of
from ddh_twin_py.gap_bench.intervals import Estimate, mean, median, share
from ddh_twin_py.gap_bench.kept_answers import KEY, kept_answers, plain
from ddh_twin_py.gap_bench.plan import LEVELS, SUITES
from ddh_twin_py.gap_bench.result_files import ResultError, read_result, result_file
from ddh_twin_py.gap_bench.running import BenchError, questions, selected
from ddh_twin_py.gap_bench.sealing import truth_of
from ddh_twin_py.names import no_such

BINS = 10
METRICS = {
    "right": "answered rightly as a whole", "detected": "a gap is found where an effect is hidden",
    "false_alarm": "a gap is found where none is", "first": "true effect first (of two: among the first two)",
    "third": "true effect among the first three",
    "probability": "mean probability on the true effect", "component": "true component first in 'where'",
    "both": "both of two in the leading hypothesis", "unknown_found": "outside the catalogue: said so",
    "unknown_component": "and at the right component", "false_unknown": "in the catalogue, yet said to be unknown",
    "closed": "median of the gap closed, over the oracle's", "parameter_error": "median error of the parameter over the effect's size",
    "coverage": "truth within the parameter's 95 % interval", "seconds": "median s per case", "megabytes": "median peak MB per case",
}
"""What is scored, with what it means."""


def answers_of_all(folders: Sequence[Path], suites: tuple[str, ...] = (), cases: int | None = None) -> tuple[list[Answer], int]:
    """The answers of several benches, and how many cases have none yet; of several each case is named with its bench.

    Args:
        folders: of benches, or files in which a score kept its answers; those are taken as they are.

    Raises:
        SealError: the truth is not what was sealed. BenchError: no such case, or none was run. ResultError: an answer that is damaged, or
            that is given twice, in folders or files.
    """
    found: list[Answer] = []
    known: set[Answer] = set()  # each as its own bench names it
    waiting = 0
    for out in folders:
        if out.is_file():
            own = [a for a in kept_answers(out) if not suites or a.suite in suites]
        else:
            names = selected(out, suites, cases)
            own = _answers_of(out, names)
            waiting += len(names) - len(own)
            own = own if len(folders) == 1 else [replace(a, name=f"{out.name}/{a.name}") for a in own]
        for answer in own:
            of_bench = replace(answer, name=answer.name.rpartition("/")[2])
            if of_bench in known and not answer.crashed:  # of two that crashed at once nothing differs
                raise ResultError(f"{out}: the answer to {answer.name} is among the others already; copies would count twice")
            known.add(of_bench)
        found += own
    return found, waiting


def of_benches(answers: Sequence[Answer], benches: Collection[str]) -> list[Answer]:
    """Those of some benches, by the name that stands before the case's: ``s3449`` of ``s3449/case_0001``.

    Raises:
        BenchError: a bench of which there is no answer.
    """
    known = list(dict.fromkeys(answer.name.rpartition("/")[0] for answer in answers))
    for bench in benches:
        if bench not in known:
            raise BenchError(f"--bench: {no_such('bench', bench, known)}")
    return [answer for answer in answers if answer.name.rpartition("/")[0] in benches]


def _answers_of(out: Path, names: Sequence[str]) -> list[Answer]:
    """The answers of those cases that were run; one that crashed is a wrong one."""
    found = []
    for name in names:
        truth = truth_of(out, name)
        results = {
            question: read_result(file)
            for question in ("blind", "left_out", "oracle") if (file := result_file(out, name, question)).is_file()
        }
        if all(question in results or "error" in results.get("blind", {}) for question in questions(out, truth, oracle=False)):
            found.append(answer_of(truth, results))
    if not found:
        raise BenchError(f"{out}: no case has an answer yet; gap-bench run {out} asks for them")
    return found


def score(answers: Sequence[Answer]) -> dict[str, Estimate]:
    """`METRICS` of some cases."""
    hidden = [a for a in answers if a.expected != "no_gap"]
    bare = [a for a in answers if a.expected == "no_gap"]
    listed = [a for a in answers if a.true]
    unknown = [a for a in answers if a.expected == "unknown"]
    two = [a for a in answers if a.both is not None]
    return {
        "right": share([a.right for a in answers]),
        "detected": share([a.detected for a in hidden]),
        "false_alarm": share([a.detected or bool(a.crashed) for a in bare]),
        "first": share([a.detected and rank <= len(a.true) for a in listed for rank in a.ranks]),
        "third": share([a.detected and rank <= 3.0 for a in listed for rank in a.ranks]),
        "probability": mean([p for a in listed for p in a.probability]),
        "component": share([bool(a.component_first) for a in hidden]),
        "both": share([bool(a.both) for a in two]),
        "unknown_found": share([a.said_unknown for a in unknown]),
        "unknown_component": share([bool(a.unknown_component) for a in unknown]),
        "false_unknown": share([a.said_unknown for a in listed]),
        "closed": median([a.closed for a in listed if a.closed is not None]),
        "parameter_error": median([e for a in listed for e in a.errors]),
        "coverage": share([c for a in listed for c in a.covered]),
        "seconds": median([a.seconds for a in answers]),
        "megabytes": median([a.megabytes for a in answers]),
    }


def reliability(answers: Sequence[Answer]) -> list[dict]:
    """Stated probability against how often it was right, in bins of a tenth; see `Answer.stated`."""
    pairs = [pair for a in answers for pair in a.stated]
    rows = []
    for k in range(BINS):
        inside = [(p, right) for p, right in pairs if min(int(p * BINS), BINS - 1) == k]
        rows.append({
            "from": k / BINS, "to": (k + 1) / BINS, "stated": sum(p for p, _ in inside) / len(inside) if inside else None,
            "right": share([right for _, right in inside]).as_json(),
        })
    return rows


def confusion(answers: Sequence[Answer]) -> list[dict]:
    """How often each truth was given each leading answer; 'no_gap' and 'crashed' are answers too."""
    counted: Counter = Counter()
    for a in answers:
        said = "crashed" if a.crashed else a.named or a.verdict
        for effect in a.true or (("unknown",) if a.expected == "unknown" else ("no_gap",)):
            counted[effect, effect if said in a.true and effect != said and a.ranks[a.true.index(effect)] <= 2.0 else said] += 1
    return [{"true": true, "said": said, "cases": n} for (true, said), n in sorted(counted.items())]


def summary(answers: Sequence[Answer]) -> dict:
    """Everything of a bench as plain data: aims, suites and levels, reliability, confusion, cases."""
    rows = []
    for suite in SUITES:
        for level in ("", *LEVELS):
            chosen = [a for a in answers if a.suite == suite and (a.level == level or not level)]
            levels = {a.level for a in answers if a.suite == suite}
            if chosen and (not level or len(levels) > 1):
                rows.append(_row(suite, level or "all", chosen))
    return {
        "report": "gap_bench", "cases": len(answers), "metrics": METRICS,
        "aims": [aim.row(answers, score) for aim in AIMS], "all": _row("all", "all", answers), "suites": rows,
        "by_commissioning": [
            _row("with commissioning" if c else "without commissioning", "all", chosen)
            for c in (True, False) if (chosen := [a for a in answers if a.commissioning == c])
        ],
        "reliability": reliability(answers), "confusion": confusion(answers),
        "crashed": [{"name": a.name, "why": a.crashed} for a in answers if a.crashed],
        KEY: [plain(a) for a in answers],
    }


def _row(suite: str, level: str, answers: Sequence[Answer]) -> dict:
    return {"suite": suite, "level": level, "cases": len(answers),
            "scores": {name: estimate.as_json() for name, estimate in score(answers).items()}}

