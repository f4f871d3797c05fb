"""`ddh-twin gap-bench`: the sealed proof of the gap diagnosis."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from ddh_twin_py.cli.arguments import (
    InputError,
    add_html,
    add_json,
    add_quiet,
    add_verb,
    refuse_recording,
    refuse_same,
    refuse_unwritable,
    seed,
    whole,
)
from ddh_twin_py.names import no_such

STEPS = ("make", "run", "score")
_EXAMPLE = "  ddh-twin gap-bench out/bench --cases 60 --jobs 2 --html out/bench.html"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "gap-bench", "hide effects in an independent plant and score the gap diagnosis",
        "make: recordings of an independent plant with hidden effects, their truth sealed by hashes. run: the diagnosis, one fresh\n"
        "process per case; finished cases are not run again. score: detection, ranking, probabilities, parameters, unknowns, with\n"
        "95 % intervals, of several benches together where several are named, and of what --json kept of others. Without a step all\n"
        "three.",
        _EXAMPLE,
    )
    parser.add_argument("steps", metavar="[make|run|score] OUT", nargs="+", help="one step or all; folder of the bench, for a "
                        "score also of several, or JSON files of scores")
    parser.add_argument("--cases", metavar="N", type=whole(1, 100_000), default=None, help="how many to make (default 60), or how many of "
        "them to run and score (default all)")
    parser.add_argument("--seed", metavar="S", type=seed, default=1, help="of the bench (default 1)")
    parser.add_argument("--suite", metavar="NAME", action="append", default=None, help="only this suite; may be given more than once: "
        "none, single, two, tolerance, left_out, outside")
    parser.add_argument("--jobs", metavar="N", type=whole(1, 256), default=os.cpu_count() or 1, help="processes at once (default all "
                        "processors)")
    parser.add_argument("--cluster", metavar="ADDRESS", help="of a dask scheduler whose workers see OUT under the same path")
    parser.add_argument("--again", metavar="WHICH", choices=("crashed", "all"), default="", help="crashed or all: run these cases once "
        "more, as after a change of the diagnosis")
    parser.add_argument("--no-oracle", action="store_true", help="do not ask the diagnosis that is told the effect")
    parser.add_argument("--bench", metavar="NAME", action="append", default=None, help="of several benches, or of answers that were kept, "
        "score this one alone, such as s3449; may be given more than once")
    parser.add_argument("--table", metavar="PAGE", type=Path, help="a Markdown file whose table of the bench is written anew")
    add_html(parser)
    add_json(parser)
    add_quiet(parser, "no progress, no table")


def run(args: argparse.Namespace) -> int:
    """Make, run and score as asked."""
    from ddh_twin_py.cli.console import put_json, say, stage

    steps, folders = _asked(args.steps)
    out = folders[0]
    from ddh_twin_py.gap_bench.plan import SUITES

    suites = tuple(dict.fromkeys(args.suite or ()))
    for suite in suites:
        if suite not in SUITES:
            raise InputError(f"--suite: {no_such('suite', suite, list(SUITES))}")
    _refuse_outputs(args, steps, out if len(folders) == 1 else None)
    if "make" in steps:
        refuse_unwritable("OUT", out, [out / "x"])
        refuse_recording("OUT", out)
        from ddh_twin_py.gap_bench.bench import make_bench

        with stage("making cases", args.quiet) as progress:
            failed = make_bench(out, args.cases or 60, args.seed, suites, args.jobs, args.cluster, progress)
        for line in failed:
            say(f"not made: {line}")
    if "run" in steps:
        from ddh_twin_py.fleet.progress import FleetProgress
        from ddh_twin_py.gap_bench.running import answered, run_bench, selected

        names = selected(out, suites, args.cases)
        far = FleetProgress(len(names), 0 if args.again == "all" else len(answered(out, names, not args.no_oracle)))
        with stage(f"diagnosing {len(names)} cases", args.quiet, far.said) as progress:
            crashed = run_bench(out, args.jobs, suites, args.cases, oracle=not args.no_oracle, cluster=args.cluster,
                                again=args.again, progress=far.then(progress))
        if crashed:
            say(f"{len(crashed)} cases crashed and count as wrong: {', '.join(crashed)}")
    if "score" in steps:
        from ddh_twin_py.gap_bench.scoring import answers_of_all, of_benches, summary
        from ddh_twin_py.report.bench.page import gap_bench_document, gap_bench_end
        from ddh_twin_py.report.page.document import write_json

        answers, waiting = answers_of_all(folders, suites, args.cases)
        if waiting:
            say(f"{waiting} cases have no answer yet and are left out of the scores")
        if args.bench:
            answers = of_benches(answers, args.bench)
        scored, named = summary(answers), ", ".join(str(folder) for folder in folders)
        alone = len(folders) == 1 and out.is_dir()
        if alone:
            write_json(out / "scores.json", scored)
        if args.html or alone:
            gap_bench_document(scored, named).write(args.html or out / "scores.html")
        if args.table:
            from ddh_twin_py.report.bench.table import write_table

            write_table(scored, args.table)
        if args.json:
            put_json(args.json, {**scored, "end_matter": gap_bench_end(named).as_json()})
        if not args.quiet and args.json != "-":
            print_scores(scored)
    return 0


def _refuse_outputs(args: argparse.Namespace, steps: tuple[str, ...], alone: Path | None) -> None:
    """Before hours of work: what only a score can write, a page without a place for the table, or one path twice.

    A bench that is scored ``alone`` keeps its scores in its folder.
    """
    given = {name: value for name in ("table", "html", "json", "bench") if (value := getattr(args, name))}
    if given and "score" not in steps:
        raise InputError(f"--{next(iter(given))}: is for the step score, which {steps[0]} is not")
    if alone is not None:
        own = [alone / "scores.json"] + [alone / "scores.html"] * (not args.html)
        refuse_same("OUT", own, {"--table": args.table, "--html": args.html, "--json": args.json})
    if args.table is None:
        return
    from ddh_twin_py.report.bench.table import place_of

    place_of(args.table)
    for name in ("html", "json"):
        refuse_same(f"--{name}", [given[name]] if name in given else [], {"--table": args.table})


def _asked(words: list[str]) -> tuple[tuple[str, ...], list[Path]]:
    folders = [Path(word) for word in dict.fromkeys(words[1:])]
    if words[0] == "score" and folders:
        return ("score",), folders
    if words[0] in STEPS:
        if len(folders) != 1:
            raise InputError(f"{words[0]}: {len(folders)} folders were given, one is needed")
        return (words[0],), folders
    if folders:
        raise InputError(f"{words[0]!r} is no step, valid are {', '.join(STEPS)}")
    return STEPS, [Path(words[0])]


def print_scores(scored: dict) -> None:
    """Two tables on standard output: every score over all cases, the main ones by suite and level."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from ddh_twin_py.cli.console import output
    from ddh_twin_py.report.bench.page import shown, verdict

    console = output()
    console.print(verdict(scored))
    columns = [scored["all"], *scored["by_commissioning"]]
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for name in ("score (95 % interval), cases", *(row["suite"] for row in columns)):
        table.add_column(name)
    for name, words in scored["metrics"].items():
        table.add_row(words, *(shown(name, row["scores"][name]) for row in columns))
    console.print(table)
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for name in ("suite", "level", "cases", "right", "gap said", "true first", "first three"):
        table.add_column(name)
    for row in scored["suites"]:
        scores = row["scores"]
        said = "detected" if scores["detected"]["n"] else "false_alarm"
        table.add_row(row["suite"], row["level"], str(row["cases"]),
                      *(shown(name, scores[name]).rsplit(",", 1)[0] for name in ("right", said, "first", "third")))
    console.print(table)
    for row in scored["crashed"]:
        console.print(f"crashed: {row['name']}: {row['why']}")
