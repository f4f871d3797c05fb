"""The answers of a bench on disk: one file for each case and question."""

from __future__ import annotations

from pathlib import Path

from ddh_twin_py.rig.files import read_json

_ANSWERED = {"report", "seconds", "megabytes"}
_NEEDED = {"verdict", "gap", "where", "why"}


class ResultError(ValueError):
    """A file of results that no run of the bench has left so; one line that names it."""


def result_file(out: Path, name: str, question: str) -> Path:
    """Where the answer to one question about one case is kept."""
    return out / "results" / f"{name}.{question}.json"


def read_result(file: Path) -> dict:
    """What a process answered: `report`, `seconds` and `megabytes`, or `error`.

    Raises:
        ResultError: the file is cut off, or holds something else. OSError: it cannot be read.
    """
    try:
        found = read_json(file)
    except ValueError as error:
        raise _damaged(file, str(error)) from None
    if isinstance(found, dict) and "error" in found:
        return found
    lacking = sorted(_ANSWERED - set(found)) if isinstance(found, dict) else ["report"]
    if not lacking:
        report = found["report"]
        lacking = [f"report.{key}" for key in sorted(_NEEDED - set(report))] if isinstance(report, dict) else ["report"]
    if lacking:
        raise _damaged(file, f"{', '.join(lacking)} not in it")
    return found


def is_answered(file: Path) -> bool:
    """Whether there is an answer, or an error, in the file; one that is damaged is none."""
    try:
        read_result(file)
    except (FileNotFoundError, ResultError):
        return False
    return True


def _damaged(file: Path, why: str) -> ResultError:
    return ResultError(f"{file}: is no answer to a case ({why}); ddh-twin gap-bench run {file.parent.parent} asks for it once more")
