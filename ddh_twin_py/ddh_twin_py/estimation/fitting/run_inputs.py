"""What drives a free run over a recording, interval by interval."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.physics.free_run import COMMAND_PARTS


@dataclass(frozen=True)
class RunInputs:
    """Inputs of n intervals.

    Attributes:
        interval: s. command: rad/s, at the edges of the `COMMAND_PARTS` parts of each, (n COMMAND_PARTS + 1,). air: K, (n,).
        placed: where the measured rod is put at standstills, m, (n,), NaN elsewhere. axis: end of each, s, (n,).
    """

    interval: float
    command: np.ndarray
    air: np.ndarray
    placed: np.ndarray
    axis: np.ndarray = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis", self.interval * np.arange(1, self.air.size + 1))

    def of_every(self, group: int) -> RunInputs:
        """The same in intervals that are ``group`` times as long; the last goes on as the recording ends."""
        command = self.command[::group]
        missing = -(-self.air.size // group) * COMMAND_PARTS + 1 - command.size
        command = np.concatenate([command, np.full(max(missing, 0), self.command[-1])])
        return RunInputs(group * self.interval, command, self.air[::group].copy(), self.placed[::group].copy())
