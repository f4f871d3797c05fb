"""A fault that the plant can be given: what it changes, in which quantity its size is said."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

Apply = Callable[[np.ndarray, np.ndarray, float], None]


@dataclass(frozen=True)
class Fault:
    """One fault.

    Attributes:
        id: name; that of the catalogue where it is listed there.
        component, domain: where it acts. parameter, unit: the quantity that is reported.
        apply: changes the sheet's record (1,) and the condition (1,) in place, given a departure.
        nominal: value of the quantity without the fault, from the sheet's record (1,).
        step: a departure that is noticed on most duties. lowest, highest: possible departures.
        paths: quantities of the sheet that it looks like, with the power by which each enters the reported quantity.
        ratio: whether the quantity is a ratio to the rig as built.
        listed: whether a gap report may name it.
    """

    id: str
    component: str
    domain: str
    parameter: str
    unit: str
    apply: Apply
    nominal: Callable[[np.ndarray], float]
    step: float
    lowest: float = 0.0
    highest: float = math.inf
    paths: tuple[tuple[str, float], ...] = ()
    ratio: bool = False
    listed: bool = True

    @property
    def signs(self) -> tuple[float, ...]:
        """Directions in which it may go."""
        return tuple(sign for sign in (1.0, -1.0) if (self.highest if sign > 0.0 else -self.lowest) > 0.0)

    def limit(self, sign: float) -> float:
        """Largest departure in a direction, not signed."""
        return self.highest if sign > 0.0 else -self.lowest


def adding(field: str) -> Apply:
    """A departure that is added to a field of the condition."""

    def apply(params: np.ndarray, condition: np.ndarray, x: float) -> None:
        condition[field] += x

    return apply


def zero(record: np.ndarray) -> float:
    """Nominal value of what is added."""
    return 0.0
