"""A rig as its engineer describes it: parameters with priors, effects with neutral values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.gap.effect import Effect


@dataclass(frozen=True)
class Parameter:
    """A parameter of the model with its prior.

    Attributes:
        name: field of the parameter record. value, std: mean and standard deviation of the prior, in ``unit``.
        source: where the prior comes from. lowest, highest: what laws allow.
    """

    name: str
    value: float
    std: float
    unit: str
    source: str
    lowest: float = -math.inf
    highest: float = math.inf


@dataclass(frozen=True)
class Description:
    """What is known of a rig before its recordings are looked at.

    Attributes:
        rig: name. source: who measured it, where a user gets the recordings.
        parameters: with priors. neutral: fields of the record that effects change, and constants, with the values that they have
            without any effect. effects: catalogue.
        places: signal to component and domain, where a cause that no effect explains is looked for when it shows in that signal.
        assumptions: texts for the end of the page. cut: standard deviations of its prior beyond which no parameter goes.
    """

    rig: str
    source: str
    parameters: Sequence[Parameter]
    neutral: Mapping[str, float]
    effects: Sequence[Effect]
    places: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    assumptions: Sequence[str] = ()
    cut: float = math.inf

    def record(self) -> np.ndarray:
        """Parameter record (1,) at the priors' means, no effect acting."""
        values = {p.name: p.value for p in self.parameters} | dict(self.neutral)
        record = np.zeros(1, dtype=[(name, np.float64) for name in values])
        for name, value in values.items():
            record[name] = value
        return record
