"""Runs the commands of the documents and compares what they print with what the documents say.

usage: python scripts/run_documents.py [--write] [PAGE ...]        (default: README.md and all of docs/)

A comment before a fenced block says what becomes of it:

    <!-- run -->               a bash block: run, in a folder of the page's own with bags/ and ddh_twin_py/config/ in it
    <!-- refused: N -->        a bash block of one command that has to leave with exit code N
    <!-- output -->            a text block: what the block before it prints on standard output, a refused one on standard error too
    <!-- file: NAME -->        a block of any kind: written to that file, for the commands that follow
    <!-- not run: WHY -->      a bash block that cannot be run here

Words are compared, numbers are not: they differ in the last digits between machines. --write puts what was printed into the page.
A block ends at the first command that fails. Whatever would hide a failure from bash (&&, ||, &, !, if, while, until, a command in
a command) is refused: write one command a line.
Leaves with 1 where a command failed or printed other words.
"""

from __future__ import annotations

import argparse
import difflib
import os
import re
import shlex
import subprocess
import sys
import tempfile
import textwrap
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINKED = ("bags", "ddh_twin_py/config")
"""Paths of the checkout that commands may name, as one who stands in it would."""
_BLOCK = re.compile(
    r"^(?P<indent> *)(?:<!-- (?P<mark>run|refused: \d+|output|file: \S+|not run: [^\n]+?) -->\n(?P=indent))?"
    r"```(?P<kind>[\w-]*)\n(?P<text>.*?)"
    r"^(?P=indent)```$",
    re.M | re.S,
)
_NUMBER = re.compile(r"[-+−±]?\d[\d.,]*(?:e[-+]?\d+)?")


@dataclass(frozen=True)
class Block:
    """One fenced block: its mark ('' where there is none), language, text, and where it stands in the page."""

    mark: str
    kind: str
    text: str
    start: int
    stop: int
    line: int
    indent: str


def blocks_of(page: str) -> list[Block]:
    """All fenced blocks of a page, those inside a list too."""
    return [
        Block(match["mark"] or "", match["kind"], textwrap.dedent(match["text"]), match.start("text"), match.end("text"),
              page.count("\n", 0, match.start("text")), match["indent"])
        for match in _BLOCK.finditer(page)
    ]


def words_of(text: str) -> str:
    """What is compared: words, numbers as #, however the lines are broken."""
    return re.sub(r"[#\s]*#[#\s]*", " # ", " ".join(_NUMBER.sub("#", text).split()))


def hiding(commands: str) -> str:
    """What in these commands would hide a failure from `bash -e`; empty where nothing does."""
    bare = re.sub(r"'[^']*'", "''", commands)  # in single quotes nothing is special
    for special in ("$(", "`", "<(", ">("):
        if special in bare:
            return special
    try:
        words = shlex.shlex(commands, posix=True, punctuation_chars=True)
        words.whitespace_split = True
        found = list(words)
    except ValueError:
        return ""  # bash says it better
    return next((word for word in found if word in ("&&", "||", "&", "|&", "!", "if", "while", "until")), "")


def run_page(path: Path, write: bool = False, say=print) -> list[str]:
    """Run the marked blocks of a page in order; what was wrong, a line each."""
    page, wrong, offset = path.read_text("utf-8"), [], 0
    printed = None
    with tempfile.TemporaryDirectory(prefix="ddh_docs_") as scratch:
        for name in LINKED:
            (Path(scratch) / name).parent.mkdir(parents=True, exist_ok=True)
            os.symlink(ROOT / name, Path(scratch) / name)
        for block in blocks_of(page):
            where = f"{path.name}:{block.line}"
            if block.mark.startswith("file: "):
                target = Path(scratch) / block.mark.removeprefix("file: ")
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_text(block.text, "utf-8")
            elif block.mark == "run" or block.mark.startswith("refused: "):
                expected = int(block.mark.removeprefix("refused: ")) if block.mark != "run" else 0
                if special := hiding(block.text):
                    wrong.append(f"{where}: {special} hides whether a command failed; write one command a line, and a command that is to "
                                 "fail into a block of its own after <!-- refused: N -->")
                    break
                if expected and len(block.text.replace("\\\n", " ").strip().splitlines()) > 1:
                    wrong.append(f"{where}: one command is refused in a block, the others belong into a block before")
                    break
                started = time.monotonic()
                done = subprocess.run(["bash", "-euo", "pipefail", "-c", block.text], cwd=scratch, text=True,
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT if expected else subprocess.PIPE,
                                      env={**os.environ, "COLUMNS": "86", "NO_COLOR": "1"})
                say(f"{where}: {time.monotonic() - started:.0f} s: {block.text.strip().splitlines()[0]}")
                printed = done.stdout
                if done.returncode != expected:
                    last = (done.stderr or done.stdout).strip().splitlines()[-1:]
                    instead = f" and not {expected}" if expected else ""
                    wrong.append(f"{where}: exit code {done.returncode}{instead}: {' '.join(last)}")
                    break  # what follows builds on it
            elif block.mark == "output":
                if printed is None:
                    wrong.append(f"{where}: an output with no command before it")
                elif write:
                    told = textwrap.indent(f"{printed.rstrip()}\n", block.indent) if printed.strip() else ""
                    page = page[: block.start + offset] + told + page[block.stop + offset :]
                    offset += len(told) - (block.stop - block.start)
                elif words_of(printed) != words_of(block.text):
                    change = [line for line in difflib.ndiff([words_of(block.text)], [words_of(printed)]) if line[:1] in "-+"]
                    wrong.append(f"{where}: prints other words, run with --write: " + " | ".join(line[:300] for line in change))
    if write and not wrong:
        path.write_text(page, "utf-8")
    return wrong


def main(argv: list[str]) -> int:
    """Run the pages that were named, or all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", metavar="PAGE", nargs="*", help="Markdown files")
    parser.add_argument("--write", action="store_true", help="put what was printed into the pages")
    args = parser.parse_args(argv)
    pages = [Path(page) for page in args.pages] or [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    wrong = []
    for page in pages:
        if any(block.mark == "run" or block.mark.startswith("refused: ") for block in blocks_of(page.read_text("utf-8"))):
            wrong += run_page(page, args.write)
    for line in wrong:
        print(line, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
