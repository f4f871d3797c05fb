"""Whether what the filter has come to believe can be true of the rig that it was told.

A sensor that drifts, or one at another sensor's place, need not be refused: the filter bends parameters and
zero errors until its reading fits, and then states small uncertainties. What it had to bend tells. Tolerances are cut at 2.5
standard deviations, so that a rig within its sheet does not come near the limits below.
"""

from __future__ import annotations

import numpy as np

from ddh_twin_py.estimation.fusion.state import FusionState
from ddh_twin_py.estimation.fusion.uncertain_parameters import AMBIENT_AT, UNKNOWN_HEAT_AT, uncertain_parameters
from ddh_twin_py.estimation.sensors import SENSORS
from ddh_twin_py.rig import Rig
from ddh_twin_py.twin.sensor_errors import temperature_zero_errors

FARTHEST_PARAMETER = 3.5
"""Prior standard deviations by which a parameter may be off."""
FARTHEST_OFFSET = 5.0
"""The same of a sensor's zero error, which drifts a little."""


class Credibility:
    """Judges the state of a filter of this rig."""

    def __init__(self, rig: Rig) -> None:
        uncertain = uncertain_parameters(rig)
        self._names, prior = uncertain.names[:UNKNOWN_HEAT_AT], uncertain.prior[:UNKNOWN_HEAT_AT]
        self._prior = np.where(prior > 0.0, prior, np.inf)
        self._middle = np.zeros(UNKNOWN_HEAT_AT)
        self._middle[AMBIENT_AT] = rig["surroundings.enclosure_rise"]
        self._zero, spread = temperature_zero_errors(rig)
        self._spread = np.where(spread > 0.0, spread, np.inf)

    def parameter(self, state: FusionState) -> tuple[str, float]:
        """The parameter that is farthest from its prior, and by how many of its standard deviations, signed."""
        off = (state.deviation[:UNKNOWN_HEAT_AT] - self._middle) / self._prior
        worst = int(np.argmax(np.abs(off)))
        return self._names[worst], float(off[worst])

    def offset(self, state: FusionState) -> tuple[str, float, float]:
        """The sensor whose zero error is farthest from its prior, by how many standard deviations, and the zero error, K."""
        off = (state.offset - self._zero) / self._spread
        worst = int(np.argmax(np.abs(off)))
        return SENSORS[worst], float(off[worst]), float(state.offset[worst])

    def doubted(self, state: FusionState) -> int:
        """How many sensors' zero errors are farther from their priors than `FARTHEST_OFFSET`."""
        return int(np.count_nonzero(np.abs((state.offset - self._zero) / self._spread) > FARTHEST_OFFSET))

    def doubt(self, state: FusionState) -> str:
        """What cannot be true of the rig, a sentence; empty where nothing is in doubt."""
        said = []
        sensor, off, zero = self.offset(state)
        if abs(off) > FARTHEST_OFFSET:
            said.append(f"temperature/{sensor} is held to read {zero:+.1f} K off, {abs(off):.0f} standard deviations of its zero error")
        name, off = self.parameter(state)
        if abs(off) > FARTHEST_PARAMETER:
            said.append(f"{name} is held to be {abs(off):.1f} standard deviations {'above' if off > 0.0 else 'below'} the rig file's")
        return "; ".join(said) + ": a sensor or the rig is not what the rig file says, errors may exceed what is stated" if said else ""
