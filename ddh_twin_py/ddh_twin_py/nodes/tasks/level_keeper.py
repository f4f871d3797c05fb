"""Keeps the normal levels of the gap's running test on disk, beside the node's own work."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ddh_twin_py.gap.watch.normal_level import NormalLevel, load_levels, save_levels
from ddh_twin_py.gap.watch.watch import PHASES


class LevelKeeper:
    """Loads a file of normal levels where there is one, and writes those that are learned.

    `rig_id` is the machine that the file is of, '' while that is not known. Raises NormalLevelError where the file is there and
    cannot be used.
    """

    def __init__(self, path: str, bin_length: float) -> None:
        self.path, self._bin_length = Path(path), bin_length
        self.rig_id, self._levels = load_levels(self.path, bin_length, PHASES) if self.path.exists() else ("", {})
        self.failure = ""
        self._under_way: set[str] = set()
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="normal levels")

    def of(self, rig_id: str) -> Mapping[str, NormalLevel]:
        """The levels on disk, none where they are of another machine."""
        return {} if self._another(rig_id) else self._levels

    def _another(self, rig_id: str) -> bool:
        return bool(self.rig_id and rig_id and self.rig_id != rig_id)

    def keep(self, rig_id: str, levels: Mapping[str, NormalLevel]) -> None:
        """Have them written soon, where a signal is among them that is not on disk, or the machine was not named there; never over those of
        another machine. Levels of a machine that is not named go to that of the file.

        What could not be written is tried again at the next call.
        """
        unnamed = bool(levels and rig_id and not self.rig_id) and not self._under_way
        if (unnamed or not set(levels) <= set(self._levels) | self._under_way) and not self._another(rig_id):
            self._under_way = set(levels)
            self._writer.submit(self._write, rig_id or self.rig_id, dict(levels))

    def _write(self, rig_id: str, levels: dict[str, NormalLevel]) -> None:
        try:
            save_levels(self.path, rig_id, self._bin_length, levels)
            self.rig_id, self._levels, self.failure = self.rig_id or rig_id, levels, ""
        except (OSError, ValueError) as error:
            self.failure = f"{self.path}: cannot be written: {getattr(error, 'strerror', None) or error}"
        finally:
            self._under_way = set()

    def close(self) -> None:
        """Write what waits and end."""
        self._writer.shutdown()
