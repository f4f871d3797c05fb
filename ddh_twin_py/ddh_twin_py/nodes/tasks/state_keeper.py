"""Keeps the filter's state on disk, beside the node's own work."""

from __future__ import annotations

import copy
import os
import threading
from pathlib import Path

from ddh_twin_py.bags.numbering import numbered
from ddh_twin_py.estimation.fusion.state import FusionState
from ddh_twin_py.estimation.fusion.state_file import OLDEST, SavedState, StateFileError, load_state, save_state
from ddh_twin_py.nodes.base.parameters import NodeError
from ddh_twin_py.rig.files import why_no_file


class StateKeeper:
    """Loads a state file at the start and writes snapshots of the state in a thread of its own.

    `saved` is what was found, `note` why it was not (to be told to people; no warning where `first`: nothing was kept yet), `written`
    how often the file was written, `failure` why it could not be. A file that is no state of this filter, of another rig, or newer than
    the data, as whoever plays yesterday's recording finds it, is not overwritten: it is set aside under its name with `.old`, or
    `.old_2` and so on where that is taken, before the first state is written.
    """

    def __init__(self, path: str, like: FusionState) -> None:
        self.path = Path(path)
        self.saved: SavedState | None = None
        self.note, self.first = "", False
        self.written = 0
        self.failure = ""
        self._kept_aside = False  # whether what is on disk is kept under another name before a state is written
        self._rig_id = ""  # of the state on disk, '' where that is not known
        self._next: tuple[FusionState, str, int] | None = None
        self._changed = threading.Condition()
        self._closing = False
        folder = self.path.absolute().parent
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if self.path.exists() and not self.path.is_file():
                raise NodeError(f"parameter state_file is {path}: that is no regular file; name a file that is one, or is not there yet")
            if why := why_no_file(folder):
                raise NodeError(f"parameter state_file is {path}: it cannot be written: {folder}: {why}")
            self.saved = load_state(self.path, like)
            self._rig_id = self.saved.rig_id if self.saved else ""
            self.first = self.saved is None
            self.note = f"{self.path}: no state yet, starting without" if self.first else ""
        except StateFileError as error:
            self._kept_aside = True
            self.note = f"{error}; starting without, and kept as {self._aside().name} once a state is written"
        except OSError as error:
            raise NodeError(f"parameter state_file is {path}: {error.strerror or error}") from None
        self._thread = threading.Thread(target=self._write, name="state file", daemon=True)
        self._thread.start()

    def _aside(self) -> Path:
        return next(path for path in numbered(self.path.with_name(f"{self.path.name}.old")) if not os.path.lexists(path))

    def refusal(self, age: float, rig_id: str) -> str:
        """Why the state found does not fit data that begins `age` s after it, '' if it does; a newer one is kept aside from then on."""
        kept = f"not used, and kept as {self._aside().name} once a state is written"
        if age < 0.0:
            self._kept_aside = True
            return f"{self.path}: is {-age:.0f} s newer than the data; {kept}"
        if age > OLDEST:
            return f"{self.path}: is {age / 86400.0:.0f} days old, more than {OLDEST / 86400.0:.0f}; not used"
        if rig_id and self.saved.rig_id and rig_id != self.saved.rig_id:
            return f"{self.path}: is of rig {self.saved.rig_id!r}, this is {rig_id!r}; {kept}"
        return ""

    def keep(self, state: FusionState, rig_id: str, stamp_ns: int) -> None:
        """Have this state written soon; a newer one may take its place before."""
        with self._changed:
            self._next = copy.deepcopy(state), rig_id, stamp_ns
            self._changed.notify()

    def close(self) -> None:
        """Write what waits and end."""
        with self._changed:
            self._closing = True
            self._changed.notify()
        self._thread.join(timeout=5.0)

    def _write(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._next is not None or self._closing)
                waiting, self._next = self._next, None
                if waiting is None:
                    return
            state, rig_id, stamp_ns = waiting
            try:
                another = bool(rig_id and self._rig_id and rig_id != self._rig_id)
                if (self._kept_aside or another) and self.path.exists():  # it may have been removed since
                    self.path.replace(self._aside())
                self._kept_aside, self._rig_id = False, rig_id or self._rig_id
                save_state(self.path, state, rig_id, stamp_ns)
                self.written += 1
                self.failure = ""
            except OSError as error:
                self.failure = f"{self.path}: cannot be written: {error.strerror or error}"
