"""A test of a direct driven unit, rehearsed on its duty, as `separating` asks for it."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.fitting.problem import Problem
from ddh_twin_py.estimation.fitting.unknowns import offset_paths, with_offsets
from ddh_twin_py.gap.drive.direct_drive import COARSE, DirectDrive
from ddh_twin_py.gap.effect import Acting, apply
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.next_test.separating import Trial


class RehearsedTrial(Trial):
    """A rehearsed test.

    Args:
        model, linearised: of the recordings. experiment: the rehearsal; sensors that the recordings lack have unknown zeros, and what no
            sensor reads may begin otherwise.
    """

    def __init__(self, model: DirectDrive, linearised: Linearised, experiment: Experiment) -> None:
        added = [path for path in offset_paths([experiment]) if path not in model.paths]
        super().__init__(experiment.signals, linearised.discrepancy, len(added) + experiment.open_begins)
        self.experiment = experiment
        self._of_rig, self._of_case = len(model.paths), model.size
        self._problem = Problem([experiment], with_offsets(model.rig, added), model.paths + added, linearised.discrepancy)

    def predict(self, theta: np.ndarray, acting: Acting) -> dict[str, np.ndarray]:
        own = self._own(theta)
        return self.experiment.predict(self._record(own, acting), COARSE, begin=self._problem.begin(0, own))

    def record(self, theta: np.ndarray, acting: Acting) -> np.ndarray:
        """Parameter record (1,) of the test; see `predict`."""
        return self._record(self._own(theta), acting)

    def _own(self, theta: np.ndarray) -> np.ndarray:
        """Deviations of the test, (k,): how the case's recordings began is not part of it."""
        added = theta[self._of_case :]
        return np.concatenate([theta[: self._of_rig], added, np.zeros(self._problem.size - self._of_rig - added.size)])

    def _record(self, own: np.ndarray, acting: Acting) -> np.ndarray:
        return apply(acting, self._problem.record(0, own))
