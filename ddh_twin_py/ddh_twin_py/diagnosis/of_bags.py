"""Diagnose a case given as bags."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path

from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.gap.diagnose import Recordings, stage_of
from ddh_twin_py.gap.diagnose import diagnose as diagnose_recordings
from ddh_twin_py.gap.diagnosis import Diagnosis
from ddh_twin_py.rig import Rig

__all__ = ["diagnose", "stage_of"]


def diagnose(field: Sequence[Path], commissioning: Path | None, validation: Path | None, rig: Rig, without: Collection[str] = (),
             only: Collection[str] | None = None, progress: Callable[[float], None] | None = None,
             namespace: str | None = None) -> Diagnosis:
    """Read the bags and diagnose them; see `gap.diagnose.diagnose`.

    Args:
        namespace: of the rig, where a bag holds more than one.

    Raises:
        BagError: a bag that cannot be read.
        ExperimentError: a recording that no free run can be compared with.
    """
    read = [None if path is None else read_recording(path, namespace) for path in (commissioning, validation)]
    recordings = Recordings([read_recording(path, namespace) for path in field], *read)
    return diagnose_recordings(recordings, rig, without, only, progress)
