"""What the models publish, from their messages to the arrays that the gap watch takes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ddh_msgs.msg import ResidualArray, TemperatureEstimateArray
from ddh_twin_py.estimation.sensors import NODE_OF_SENSOR, SENSORS
from ddh_twin_py.gap.watch import HYDRAULIC
from ddh_twin_py.nodes.conversion import FREE_RUN
from ddh_twin_py.nodes.wire import BulkParser

RESIDUAL_TOPIC = "hydraulics/residuals"
ESTIMATE_TOPIC = "temperature/estimates"
_FRESH = 1e-3  # s; an older reading was told before
_SOURCE = FREE_RUN.encode() + b"\0"
_HEAD = 96  # bytes of a message in which its source is named
_VELOCITY = "rod_velocity"


class FreeRunResiduals:
    """Residuals of the free run out of `hydraulics/residuals`, which holds those of the soft sensor too."""

    def __init__(self) -> None:
        self._parser = BulkParser(ResidualArray)

    def parse(self, messages: Sequence[bytes]) -> list[tuple[np.ndarray, ...]]:
        """Runs of stamps int64 (n,) in ns, measured, predicted (n, S) and rod velocity in m/s (n,), NaN for a signal that is not named."""
        runs = []
        for example, stamps, values in self._parser.parse([m for m in messages if _SOURCE in m[:_HEAD]]):
            names = [residual.signal for residual in example.residuals]
            measured, predicted = values["residuals.measured"], values["residuals.predicted"]
            ordered = [_columns(block, names, [name for name, _, _ in HYDRAULIC]) for block in (measured, predicted)]
            velocity, expected = (_columns(block, names, [_VELOCITY])[:, 0] for block in (measured, predicted))
            runs.append((stamps, *ordered, np.where(np.isfinite(velocity), velocity, expected)))
        return runs


class FreeRunTemperatures:
    """Readings of the sensors and the free run's temperatures out of `temperature/estimates`."""

    def __init__(self) -> None:
        self._parser = BulkParser(TemperatureEstimateArray)

    def parse(self, messages: Sequence[bytes]) -> list[tuple[np.ndarray, ...]]:
        """Runs of stamps int64 (n,) in ns, measured and predicted in degC (n, S); NaN where there is no new reading."""
        runs = []
        for example, stamps, values in self._parser.parse(messages):
            names = [estimate.location for estimate in example.estimates]
            nodes = [NODE_OF_SENSOR[sensor] for sensor in SENSORS]
            measured, predicted, age = (
                _columns(values[f"estimates.{name}"], names, nodes) for name in ("measured", "predicted", "measured_age")
            )
            runs.append((stamps, np.where(age < _FRESH, measured, np.nan), predicted))
        return runs


def _columns(block: np.ndarray, names: Sequence[str], wanted: Sequence[str]) -> np.ndarray:
    """Columns of the wanted names; NaN for one that is not there."""
    ordered = np.full((block.shape[0], len(wanted)), np.nan)
    for j, name in enumerate(wanted):
        if name in names:
            ordered[:, j] = block[:, names.index(name)]
    return ordered
