"""Answers as rows of plain data, as a score keeps them, and back: a bench that was run elsewhere is scored with others."""

from __future__ import annotations

import math
import reprlib
import sys
from collections.abc import Mapping
from dataclasses import MISSING, fields
from pathlib import Path
from typing import get_args, get_origin, get_type_hints

from ddh_twin_py.gap_bench.answers import Answer
from ddh_twin_py.gap_bench.plan import LEVELS, SUITES
from ddh_twin_py.gap_bench.result_files import ResultError
from ddh_twin_py.rig.files import read_json

KEY = "answers"
"""Of a score's JSON: its rows."""
_WITHOUT_VALUE = {"ranks": math.inf, "seconds": math.nan, "megabytes": math.nan}  # what JSON has no number for
_WORDS = {"suite": SUITES, "level": ("", *LEVELS), "expected": ("explained", "no_gap", "unknown"),
          "verdict": ("", "no_gap", "explained", "ambiguous", "unknown", "insufficient")}  # fmt: skip
_LOWEST = {"ranks": 1.0, "probability": 0.0, "pairs": 0.0, "none": 0.0, "errors": 0.0, "seconds": 0.0, "megabytes": 0.0}
_HIGHEST = {"probability": 1.0, "pairs": 1.0, "none": 1.0}
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
        found = read_json(file)
    except ValueError as error:
        raise _no_score(file, str(error)) from None
    rows = found.get(KEY) if isinstance(found, dict) else None
    if not isinstance(rows, list) or not rows:
        raise _no_score(file, f"{KEY} not in it")
    return [_answer(row, file, number) for number, row in enumerate(rows, 1)]


def _answer(row: object, file: Path, number: int) -> Answer:
    if not isinstance(row, Mapping) or not _HINTS.keys() >= set(row) >= _NEEDED:
        odd = sorted(set(row) ^ _HINTS.keys()) if isinstance(row, Mapping) else ["no row"]
        raise _no_score(file, f"{KEY} {number}: {', '.join(odd)}")
    full = {}
    for name, value in row.items():
        try:
            full[name] = _full(value, _WITHOUT_VALUE.get(name))
            sound = _is(full[name], _HINTS[name])
        except RecursionError:
            sound = False
        if not sound:
            raise _no_score(file, f"{KEY} {number}: {name} is {reprlib.repr(value)}")
    answer = Answer(**full)
    if odd := _impossible(answer, row):
        raise _no_score(file, f"{KEY} {number}, case {answer.name!r}: {odd}")
    return answer


def _impossible(answer: Answer, row: Mapping) -> str:
    """What no case can be answered with, in words that name the field; '' where there is nothing."""
    for name, valid in _WORDS.items():
        if (word := getattr(answer, name)) not in valid:
            return f"{name} is {word!r}, valid are {', '.join(map(repr, valid))}"
    if bool(answer.crashed) == bool(answer.verdict):
        return f"verdict is {answer.verdict!r} beside crashed {reprlib.repr(answer.crashed)}; one of the two is given"
    for name in row:
        lowest, highest = _LOWEST.get(name, -sys.float_info.max), _HIGHEST.get(name, sys.float_info.max)
        for value in _numbers(row[name]):
            if not lowest <= value <= highest:
                most = f" to {highest:g}" if name in _HIGHEST else ""
                least = f" from {lowest:g}" if name in _LOWEST else ""
                return f"{name} is {reprlib.repr(value)}, a finite number{least}{most} is needed"
    for name, other in (("ranks", "true"), ("probability", "true"), ("covered", "errors")):
        if len(getattr(answer, name)) != len(getattr(answer, other)):
            return f"{name} has {len(getattr(answer, name))} values, {other} {len(getattr(answer, other))}"
    if len(answer.covered) > len(answer.true):
        return f"covered has {len(answer.covered)} values, true {len(answer.true)}"
    return ""


def _numbers(value) -> list[float]:
    """The numbers in a value as the file has it; what has none, null, is left out."""
    if isinstance(value, list):
        return [number for one in value for number in _numbers(one)]
    return [value] if type(value) in (int, float) else []


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
