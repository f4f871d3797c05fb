"""Answers as rows of plain data, as a score keeps them, and back: a bench that was run elsewhere is scored with others."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import get_args, get_origin, get_type_hints

from ddh_twin_py.gap_bench.answers import Answer
from ddh_twin_py.gap_bench.result_files import ResultError

KEY = "answers"
"""Of a score's JSON: its rows."""
_WITHOUT_VALUE = {"ranks": math.inf, "seconds": math.nan, "megabytes": math.nan}  # what JSON has no number for
_HINTS = get_type_hints(Answer)
_NEEDED = {f.name for f in fields(Answer) if f.default is MISSING}


def plain(answer: Answer) -> dict:
    """One row; what is no finite number is None."""
    return {name: _plain(value) for name, value in vars(answer).items()}


def kept_answers(file: Path) -> list[Answer]:
    """The answers in a file that ``gap-bench score --json`` wrote.

    Raises:
        ResultError: the file holds something else. OSError: it cannot be read.
    """
    try:
        found = json.loads(file.read_text("utf-8"))
    except ValueError as error:
        raise _no_score(file, " ".join(str(error).split())) from None
    rows = found.get(KEY) if isinstance(found, dict) else None
    if not isinstance(rows, list) or not rows:
        raise _no_score(file, f"{KEY} not in it")
    return [_answer(row, file, number) for number, row in enumerate(rows, 1)]


def _answer(row: object, file: Path, number: int) -> Answer:
    if not isinstance(row, Mapping) or not _HINTS.keys() >= set(row) >= _NEEDED:
        odd = sorted(set(row) ^ _HINTS.keys()) if isinstance(row, Mapping) else ["no row"]
        raise _no_score(file, f"{KEY} {number}: {', '.join(odd)}")
    full = {name: _full(value, _WITHOUT_VALUE.get(name)) for name, value in row.items()}
    for name, value in full.items():
        if not _is(value, _HINTS[name]):
            raise _no_score(file, f"{KEY} {number}: {name} is {row[name]!r}")
    return Answer(**full)


def _is(value: object, hint) -> bool:
    """Whether a value is of an annotation of `Answer`."""
    inner = get_args(hint)
    if get_origin(hint) is tuple:
        if not isinstance(value, tuple):
            return False
        each = [inner[0]] * len(value) if inner[-1] is Ellipsis else inner
        return len(value) == len(each) and all(map(_is, value, each))
    if inner:
        return any(_is(value, one) for one in inner)
    return type(value) is hint or (hint is float and type(value) is int)


def _plain(value):
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return [_plain(v) for v in value] if isinstance(value, tuple) else value


def _full(value, instead: float | None):
    if isinstance(value, list):
        return tuple(_full(v, instead) for v in value)
    return instead if value is None else value


def _no_score(file: Path, why: str) -> ResultError:
    return ResultError(f"{file}: is no score of a bench ({why}); ddh-twin gap-bench score OUT --json FILE writes one")
