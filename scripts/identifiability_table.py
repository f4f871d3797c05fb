#!/usr/bin/env python3
"""What recordings inform: share of each parameter's prior deviation that a fit leaves, as docs/calibration.md shows it.

    . .venv/bin/activate
    python scripts/identifiability_table.py bags/paper_cycle CASES/case_003/commissioning
"""

from __future__ import annotations

import sys
from pathlib import Path

from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fitting.calibration import Calibration, calibrate
from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.rig import load_rig

USED = 0.7
LEFT_IN_ALL = 90
"""% that is left in every recording of those that are listed below the table."""


def name_of(folder: Path) -> str:
    """Of a recording: its case where it is a commissioning bag."""
    return folder.parent.name if folder.name == "commissioning" else folder.name


def table(fits: dict[str, Calibration]) -> str:
    """Markdown: the table, the parameters that stay at their prior in all, the pairs that are known only together."""
    left = {name: {p.name: round(100.0 * p.share) for p in fit.parameters} for name, fit in fits.items()}
    paths = sorted(set().union(*left.values()), key=lambda path: min(shares.get(path, 100) for shares in left.values()))
    stay = sorted(path for path in paths if all(shares.get(path, 100) >= LEFT_IN_ALL for shares in left.values()))
    lines = ["| parameter | " + " | ".join(left) + " |", "|---" * (len(left) + 1) + "|"]
    for path in paths:
        if path not in stay:
            lines.append(f"| `{path}` | " + " | ".join(str(shares.get(path, "–")) for shares in left.values()) + " |")
    named = ", ".join(f"`{path}`" for path in stay)
    lines += ["", f"{LEFT_IN_ALL} % or more is left in {'both' if len(left) == 2 else 'all'}: {named}."]
    pairs = [f"{name}: " + ("; ".join(f"`{a}` and `{b}` ({r:+.3f})" for a, b, r in fit.together()) or "none") for name, fit in fits.items()]
    return "\n".join([*lines, "", "Only together: " + ". ".join(pairs) + "."])


def main() -> int:
    """Fit each recording's first part and print what was learnt."""
    if len(sys.argv) < 2:
        print("error: give the folders of recordings", file=sys.stderr)
        return 2
    sheet = load_rig()
    folders = [Path(folder) for folder in sys.argv[1:]]
    print(table({name_of(f): calibrate([Experiment(read_recording(str(f)), sheet, used=USED)], sheet) for f in folders}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
