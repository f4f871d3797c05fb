"""Diagnose one case in a process of its own: `python -m ddh_twin_py.gap_bench.one_case FOLDER RESULT [...]`.

Writes the report with the seconds and the peak memory that it took. Knows nothing of the truth but what it is told to leave
out or to allow.
"""

from __future__ import annotations

import argparse
import inspect
import json
import time
from importlib import import_module
from pathlib import Path

from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.files import write_whole

ENGINE = "ddh_twin_py.diagnosis.of_bags:diagnose"
"""Module and name of what is put to the proof."""


class OneCaseError(ValueError):
    """An engine that cannot be asked that way; one line."""


def peak_megabytes() -> float:
    """Largest resident memory of this process so far, MB (10^6 byte); NaN where the system does not say."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return float(line.split()[1]) * 1024e-6
    except OSError:
        pass
    return float("nan")


def diagnose_folder(folder: Path, engine: str, without: tuple[str, ...], only: tuple[str, ...] | None) -> dict:
    """Report of a case folder, its seconds and MB.

    Raises:
        OneCaseError: the engine does not take ``only``.
    """
    module, _, name = engine.partition(":")
    diagnose = getattr(import_module(module), name)
    further = {}
    if only is not None:
        if "only" not in inspect.signature(diagnose).parameters:
            raise OneCaseError(f"{engine}: does not take 'only'")
        further["only"] = list(only)
    parts = {part: path if (path := folder / part).is_dir() else None for part in ("commissioning", "validation")}
    started = time.perf_counter()
    diagnosis = diagnose([folder / "field"], parts["commissioning"], parts["validation"], load_rig(), without=without, **further)
    return {"report": diagnosis.report, "seconds": time.perf_counter() - started, "megabytes": peak_megabytes()}


def main() -> None:
    """Read arguments, diagnose, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("result", type=Path)
    parser.add_argument("--engine", default=ENGINE)
    parser.add_argument("--without", nargs="*", default=[])
    parser.add_argument("--only", nargs="*", default=None)
    args = parser.parse_args()
    found = diagnose_folder(args.folder, args.engine, tuple(args.without), None if args.only is None else tuple(args.only))
    write_whole(args.result, json.dumps(found))


if __name__ == "__main__":
    main()
