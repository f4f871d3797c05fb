"""Which duty file is meant: by path, or one of the project's own by name."""

from __future__ import annotations

import os
from pathlib import Path

from ddh_twin_py.names import no_such


def duty_file(given: str) -> Path:
    """A duty file by path, or one of the project's own by name, beside which a folder of that name does not matter.

    Raises:
        DutyError: neither a file nor such a name; it tells the nearest name and all that are valid.
    """
    path = Path(given)
    if path.suffix or path.exists() and not path.is_dir():
        return path
    folders = [Path(__file__).resolve().parents[2] / "config" / "duty"]
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    folders += [Path(prefix) / "share/ddh_twin_py/config/duty" for prefix in prefixes if prefix]
    known = {file.stem: file for folder in reversed(folders) for file in sorted(folder.glob("*.yaml"))}
    if given not in known:
        if path.is_dir():
            return path
        from ddh_twin_py.twin.duty import DutyError  # the model is loaded only where a duty is run

        nearest = f", and {no_such('duty', given, sorted(known))}" if known else ""
        raise DutyError(f"{given}: no such duty file{nearest}")
    return known[given]
