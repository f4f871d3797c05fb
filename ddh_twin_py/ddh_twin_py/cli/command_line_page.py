"""The command line as a page of Markdown, written from the parsers: what holds for every verb, then verb by verb."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator

from ddh_twin_py.cli.arguments import Parser
from ddh_twin_py.cli.exit_codes import EXIT_CODES, NO

_FOOT = "*Written by `scripts/reference_pages.py` from the parsers; change it there.*"
_COMMON = (
    ("`--rig FILE`", "rig file with what differs from the [reference sheet](rig_sheet.md)"),
    ("`--namespace NS`", "namespace of the rig's topics"),
    ("`--html FILE`", "write the page: self-contained, prints well, ends with data split, versions, rig file and assumptions"),
    ("`--json FILE`", "write the numbers as JSON; `-` is standard output, and nothing else goes there then"),
    ("`--csv FILE`, `--parquet FILE`", "write a table"),
    ("`-o`, `--output`", "the one thing that the verb is there to write"),
    ("`--out FOLDER`", "folder for several files"),
    ("`--seed N`", "what is drawn; the same seed draws the same"),
    ("`--jobs N`", "how many processes at once"),
    ("`--quiet`", "no progress and no summary; warnings and errors stay"),
)
_SURROUNDINGS = (
    ("`NO_COLOR`", "any value: no colours on a terminal. Without a terminal there are none"),
    ("`DDH_TWIN_CACHE`", "folder in which `ddh_twin` holds the compiled models (default `$XDG_CACHE_HOME`, else `~/.cache`)"),
    ("`ROS_DOMAIN_ID`, `ROS_AUTOMATIC_DISCOVERY_RANGE`", "which graph `up` and `doctor` are in, as everywhere in ROS 2"),
    ("`CC`", "C compiler of `fmu`"),
)


def command_line_page(parser: Parser) -> str:
    """The page, for `docs/command_line.md`."""
    verbs = dict(_verbs(parser))
    lines = [
        "# Command line", "",
        "`ddh-twin VERB ...`, one verb per job. `ddh-twin VERB --help` says the same as this page, with an example. A name that is "
        "not known is answered with the nearest that is. `ddh-twin completion bash` (`zsh`, `fish`) prints what makes a shell complete "
        "verbs, options, values and files.", "",
        "| verb | |", "|---|---|", *(f"| [`{name}`](#{name}) | {about} |" for name, (_, about) in verbs.items()), "",
        "## What means the same everywhere", "",
        "| option | |", "|---|---|", *(f"| {name} | {about} |" for name, about in _COMMON), "",
        "Results go to standard output and to the files that were named, progress, warnings and errors to standard error; progress is a "
        "bar with the remaining time on a terminal, else a line at least every 30 s. A file or a bag is written whole or not at all, but "
        "for what `up` records as it comes; a bag or folder that exists is not overwritten; one path for two outputs, or one inside the "
        "other, is refused. Folders that are missing on the way to an output are made, for every option and verb, and whether it can be "
        "written is looked at before the work begins.", "",
        "## Exit codes", "",
        "| code | |", "|---|---|", *(f"| {code} | {about} |" for code, about in EXIT_CODES.items()), "",
        "| verb | its code 1 |", "|---|---|", *(f"| `{name}` | {about} |" for name, about in NO.items()), "",
        "## Environment", "",
        "| variable | |", "|---|---|", *(f"| {name} | {about} |" for name, about in _SURROUNDINGS), "",
    ]
    for name, (child, _) in verbs.items():
        lines += [f"## {name}", "", "```text", _help(child), "```", ""]
    return "\n".join([*lines, _FOOT, ""])


def _verbs(parser: Parser) -> Iterator[tuple[str, tuple[Parser, str]]]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            about = {choice.dest: choice.help for choice in action._choices_actions}
            yield from ((name, (child, about[name])) for name, child in action.choices.items())


def _help(parser: Parser) -> str:
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = "100"  # argparse asks for the width of the terminal
    try:
        return parser.format_help().strip()
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before
