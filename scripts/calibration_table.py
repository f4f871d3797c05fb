#!/usr/bin/env python3
"""How well calibrations stand on held-out data: a row of Markdown for each recording, as docs/calibration.md shows them.

    . .venv/bin/activate
    python scripts/calibration_table.py bags/paper_cycle CASES/*/commissioning
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fitting.calibration import calibrate
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.fitting.held_out import held_out
from ddh_twin_py.report.calibration.groups import group_of
from ddh_twin_py.rig import load_rig

USED = 0.7
LIMIT = 1.6  # times noise


def row(folder: Path) -> str:
    """Fit the first part of a recording and say how the rest agrees."""
    sheet = load_rig()
    experiment = Experiment(read_recording(str(folder)), sheet, used=USED)
    fitted = calibrate([experiment], sheet)
    as_given = max(ratio for ratio, _ in held_out([experiment], sheet).values())
    off = {name.removeprefix("temperature/"): ratio for name, (ratio, _) in held_out([experiment], fitted.rig).items()}
    beyond = ", ".join(f"{name} {ratio:.2f}" for name, ratio in off.items() if ratio > LIMIT) or "none"
    groups = Counter(group_of(p, fitted) for p in fitted.parameters)
    counts = " / ".join(str(groups[g]) for g in ("informed", "partly informed", "stays at prior"))
    name = folder.parent.name if folder.name == "commissioning" else folder.name
    return (f"| {name} | {len(off)} | {as_given:.1f} | {min(off.values()):.2f} … {max(off.values()):.2f} | {beyond} | {counts} | "
            f"{'yes' if fitted.settled else 'no'} | {fitted.sweeps} |")


def main() -> int:
    """Print the table."""
    if len(sys.argv) < 2:
        print("error: give the folders of recordings", file=sys.stderr)
        return 2
    print("| recording | signals | worst as given | held out, all signals | beyond 1.6 | informed / partly / prior | settled | sweeps |")
    print("|---|---|---|---|---|---|---|---|")
    for folder in sys.argv[1:]:
        print(row(Path(folder)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
