"""What is wrong with a text that is not YAML, in words for those who wrote it: YAML's own name what a parser expects."""

from __future__ import annotations

import re

import yaml

from ddh_twin_py.rig.unique_keys import CLINGS

_COLON = re.compile(r":\s")
_COMMENT = re.compile(r"\s#")
_IN_BRACKETS = ("while parsing a flow sequence", "while parsing a flow mapping")
_QUOTED = "put the value in quotes"


def fault(cause: yaml.YAMLError, text: str) -> tuple[int, str]:
    """The line of a mistake, counted from 1 and none behind the last that holds something, and what it is."""
    if isinstance(cause, yaml.reader.ReaderError):
        return text.count("\n", 0, cause.position) + 1, f"it holds the character {chr(cause.character)!r}"
    problem, mark, context = cause.problem, cause.problem_mark, cause.context
    if problem == "mapping values are not allowed here":
        line, problem = _colon(text, mark)
        return line, problem
    if problem == "could not find expected ':'":  # told of the line after
        mark = cause.context_mark
        problem = "a '-' is missing" if _before(text, mark.line).lstrip().startswith("- ") else "a ':' is missing"
    elif context == "while scanning a quoted scalar":
        mark, problem = cause.context_mark, "a quote is not closed"
    elif problem.endswith("but got '<scalar>'") and text[mark.index - 1] in "'\"" or _behind_a_quote(problem, text, mark):
        problem = "something stands behind a closing quote; a value with one kind of quotes in it stands in the other"
    elif context in _IN_BRACKETS and problem.endswith("got ':'") and _COLON.search(re.split(r"[,{[]", _begin(text, mark))[-1]):
        problem = f"a comma is missing, or a value holds a ':' with a blank behind it; {_QUOTED}"
    elif context in _IN_BRACKETS:
        comment = _COMMENT.search(text[cause.context_mark.index : mark.index])
        problem = f"a bracket is not closed, or a comma is missing by line {_line(mark, text)}"
        problem += "; what stands behind ' #' is a comment, unless it is in quotes" if comment else ""
        mark = cause.context_mark
    else:
        problem = _in_words(problem, context)
    return _line(mark, text), problem


def _in_words(problem: str, context: str | None) -> str:
    if problem == "expected the node content, but found '<stream end>'":
        return "a bracket is not closed"
    if problem == "found character '\\t' that cannot start any token":
        return "there is a tab where blanks are needed"
    if problem.endswith("that cannot start any token"):
        return f"{problem.removeprefix('found ').removesuffix(' that cannot start any token')} begins no value; put it in quotes"
    if problem == "but found another document":
        return "a second document begins"
    if problem in ("expected <block end>, but found '}'", "expected <block end>, but found ']'"):
        return f"there is a {problem[-3:]} too many"
    if problem in ("expected <block end>, but found '<block mapping start>'", "expected <block end>, but found '<block sequence start>'"):
        return "a line is indented otherwise than those that it belongs to"
    if context == "while scanning a double-quoted scalar":
        return "a '\\' in double quotes begins a sign of another kind; in single quotes it is itself"
    if problem == "mapping keys are not allowed here":
        return "character '?' begins no value; put it in quotes"
    if context == "while scanning a block scalar":
        return f"'|' and '>' begin a text of lines of its own; if it is none, {_QUOTED}"
    if problem.startswith("found undefined alias"):
        return f"{problem}; if a value begins with '*', {_QUOTED}"
    if problem.startswith("could not determine a constructor for the tag"):
        return f"there is no kind {problem.rpartition(' ')[2]}; if a value begins with '!', {_QUOTED}"
    return problem


def _colon(text: str, mark: yaml.Mark) -> tuple[int, str]:
    """Where a ':' stands that makes no entry, and why."""
    before = _before(text, mark.line)
    if _COLON.search(_begin(text, mark)):
        return mark.line + 1, f"a value holds a ':' with a blank behind it; {_QUOTED}"
    if CLINGS.match(before.lstrip()):
        return mark.line, "a blank is missing after the ':'"
    if before.strip() and ":" not in before and not before.lstrip().startswith(("#", "- ")):
        return mark.line, "a ':' is missing"
    return mark.line + 1, "there is a ':' too many, or a line is indented too far"


def _behind_a_quote(problem: str, text: str, mark: yaml.Mark) -> bool:
    return problem == "expected <block end>, but found '<scalar>'" and _begin(text, mark).rstrip().endswith(("'", '"'))


def _begin(text: str, mark: yaml.Mark) -> str:
    """Of a mark's line: what stands before the mark."""
    return text[text.rfind("\n", 0, mark.index) + 1 : mark.index]


def _before(text: str, line: int) -> str:
    """The line before one that is counted from 0; '' where it is the first."""
    return text.splitlines()[line - 1] if line else ""


def _line(mark: yaml.Mark, text: str) -> int:
    return min(mark.line, text.rstrip().count("\n")) + 1
