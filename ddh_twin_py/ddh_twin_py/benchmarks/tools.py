"""Other people's packages that the benchmark times the twin against: there or not, and why not.

They are no requirement of the twin: `scripts/bench_tools.sh` puts them into a folder of their own,
which is searched last, so that whatever the twin needs itself keeps its locked version.
"""

from __future__ import annotations

import importlib
import os
import sys
from pathlib import Path
from types import ModuleType


class NotThere(RuntimeError):
    """A package that cannot be used here; the message is the reason, one line."""


def tool(name: str) -> ModuleType:
    """A module of the benchmark's own folder.

    Raises:
        NotThere: not installed, or one of its libraries is missing.
    """
    folder = os.environ.get("DDH_BENCH_TOOLS") or str(Path(sys.prefix) / "bench")
    if folder not in sys.path:
        sys.path.append(folder)
    reason = Path(folder) / f"{name}.reason"
    try:
        return importlib.import_module(name)
    except ImportError as error:
        said = reason.read_text().strip() if reason.is_file() else str(error)
        raise NotThere(said.splitlines()[0] if said else "not installed") from None
    except OSError as error:
        raise NotThere(str(error).splitlines()[0]) from None
