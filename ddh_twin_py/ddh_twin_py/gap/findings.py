"""What single steps of a diagnosis find: traces of signals, what a place lacks, the shape of what nothing explains."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Trace:
    """One signal over the data that took no part in finding or fitting.

    Attributes:
        time: s since the start of the recording, (n,). measured, before, after: in ``unit``, (n,);
            the twin with its parameters fitted, and with the leading hypothesis added.
        unit: SI; temperatures in K. noise: of one sample. floor: see the gap's contract.
    """

    time: np.ndarray
    measured: np.ndarray
    before: np.ndarray
    after: np.ndarray
    unit: str
    noise: float
    floor: float


@dataclass(frozen=True)
class Lack:
    """What the twin lacks at a place.

    Attributes:
        component, domain, phase: names of the contract. regime: such as ``speed 40 to 80 rad/s``, empty for all.
        value, std: in ``unit``, mean over the phase or regime. share: of the explained chi-square.
        signals: readings that err, where it lies in readings and they are known.
    """

    component: str
    domain: str
    phase: str
    regime: str
    value: float
    std: float
    unit: str
    share: float
    signals: tuple[str, ...] = ()


@dataclass(frozen=True)
class Shape:
    """Drawn shape of what no listed effect explains: a curve over one variable it depends on.

    Attributes:
        variable: name with unit. at: its values, (k,). value, std: of what is lacking, in ``unit``, (k,).
        signal: in which it is lacking, empty where it is not a signal.
    """

    variable: str
    at: np.ndarray
    value: np.ndarray
    std: np.ndarray
    unit: str
    signal: str = ""
