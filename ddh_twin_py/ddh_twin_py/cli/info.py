"""`ddh-twin info`: what a recording holds and what is wrong with it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from ddh_twin_py.cli.arguments import add_bag, add_json, add_namespace, add_quiet, add_rig, add_verb

if TYPE_CHECKING:
    from ddh_twin_py.telemetry.recording import Recording

_EXAMPLE = "  ddh-twin info bags/paper_cycle"


def add_parser(subparsers) -> None:
    """Declare the verb."""
    parser = add_verb(
        subparsers, "info", "say what a recording holds and what is wrong with it",
        "Reads a bag and screens every sample: finite, in range, in order, moving, in the right unit; then holds channels against\n"
        "each other. Each finding names file, topic and value.",
        _EXAMPLE,
    )
    add_bag(parser)
    add_rig(parser)
    add_namespace(parser)
    add_json(parser)
    add_quiet(parser, "no table; warnings and errors stay")


def run(args: argparse.Namespace) -> int:
    """Read, screen, hold channels against each other, tell."""
    from dataclasses import replace

    from ddh_twin_py.bags.reader import read_recording
    from ddh_twin_py.cli.console import put_json, show_findings
    from ddh_twin_py.gap.recordings.contradictions import contradictions
    from ddh_twin_py.rig import load_rig
    from ddh_twin_py.telemetry.recording import Finding, announced_id
    from ddh_twin_py.telemetry.screening.screening import screen_by_sheet

    rig = load_rig(args.rig)
    recording = read_recording(args.bag, args.namespace).held_against(rig.oil_grade)
    screened = screen_by_sheet(recording, rig)
    another = rig.of_another(announced_id([screened]))
    said = [*([f"{screened.path}: {another}"] if another else []), *contradictions(screened, rig)]
    apart = [Finding("warning", screened.path, "", "", None, 1, text) for text in said]
    screened = replace(screened, findings=[*screened.findings, *apart])
    if args.json:
        put_json(args.json, recording_json(screened))
    if args.quiet or args.json == "-":
        show_findings(screened.findings, args.json if args.json and args.json != "-" else "ddh-twin info without --quiet")
    else:
        _show(screened, not_measured(recording))
    return 0


def not_measured(recording: Recording) -> dict[str, list[str]]:
    """Topic to the fields of which it holds no number at all, as where a log had no such column."""
    import numpy as np

    return {topic: [name for name, column in zip(stream.fields, stream.values.T, strict=True)
                    if name != "variance" and not np.isfinite(column).any()] for topic, stream in recording.streams() if len(stream)}


def recording_json(recording: Recording) -> dict:
    """What a recording holds, and its findings, as plain data."""
    from dataclasses import asdict

    return {
        "path": recording.path, "namespace": recording.namespace, "epoch_ns": recording.epoch_ns,
        "duration_s": recording.duration, "rig": asdict(recording.rig) if recording.rig else None,
        "streams": [
            {"topic": topic, "samples": len(stream), "rate_Hz": _rate(stream.time), "start_s": float(stream.time.min()),
             "stop_s": float(stream.time.max()), "fields": list(stream.fields)}
            for topic, stream in recording.streams() if len(stream)
        ],
        "findings": [asdict(finding) for finding in recording.findings],
    }


def _show(recording: Recording, missing: dict[str, list[str]]) -> None:
    from datetime import UTC, datetime

    from rich.table import Table
    from rich.text import Text

    from ddh_twin_py.cli.console import output
    from ddh_twin_py.report.units import duration, number

    console = output()
    start = datetime.fromtimestamp(recording.epoch_ns * 1e-9, UTC)
    console.print(Text(recording.path, style="bold"))
    rig = recording.rig
    told = str(rig) if rig else "not named"
    namespace = recording.namespace or "/"
    console.print(f"{duration(recording.duration)} from {start:%Y-%m-%d %H:%M:%S} UTC, namespace {namespace}")
    console.print(f"rig: {told}")
    table = Table(box=None, pad_edge=False)
    table.add_column("topic", no_wrap=True)
    for column in ("samples", "Hz", "from s", "to s", "rejected"):
        table.add_column(column, justify="right")
    for topic, stream in recording.streams():
        if len(stream):
            # a variance of 0 or NaN means unknown and is no fault, and what was never measured cannot be rejected
            judged = [i for i, name in enumerate(stream.fields) if name != "variance" and name not in missing[topic]]
            values = stream.values[:, judged]
            rejected = int((values != values).any(axis=1).sum())
            table.add_row(
                topic, str(len(stream)), number(_rate(stream.time), 1), number(float(stream.time.min()), 1),
                number(float(stream.time.max()), 1), str(rejected) if rejected else "",
            )
    console.print(table)
    for topic, fields in missing.items():
        if fields:
            console.print(f"not measured: {topic} {', '.join(fields)}", soft_wrap=True)
    if not recording.findings:
        console.print("nothing wrong was found")
    style = {"error": "red", "warning": "yellow"}
    for finding in recording.findings:
        console.print(Text.assemble((finding.severity, style.get(finding.severity, "")), ": ", finding.message))


def _rate(time) -> float:
    import numpy as np

    steps = np.diff(time)
    steps = steps[steps > 0.0]
    return float(1.0 / np.median(steps)) if steps.size else float("nan")
