"""An effect that a rig may have and the twin's baseline has not."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

DOMAINS = ("electrical", "mechanical", "hydraulic", "thermal", "measurement")
Apply = Callable[[np.ndarray, float], None]
_REFERENCES = {True: "at commissioning", False: "the sheet says", None: "expected"}


@dataclass(frozen=True)
class Beside:
    """What may have changed along with an effect, though the effect does not say so: fitted with it, and no part of its size.

    Attributes:
        law: changes a parameter record (1,) in place, given standard deviations of this change. end: of them, at which it ends.
        quantity: what it changes, from a record. about: what happens, in one sentence; ``{change}`` stands for "3.1 % more" or "less".
    """

    law: Apply
    end: float
    quantity: Callable[[np.ndarray], float]
    about: str

    def said(self, changed: np.ndarray, before: np.ndarray) -> str:
        """What happens, in one sentence; records (1,) with it and without."""
        share = self.quantity(changed) / self.quantity(before) - 1.0
        return self.about.replace("{change}", f"{100.0 * abs(share):.1f} % {'more' if share > 0.0 else 'less'}")


@dataclass(frozen=True)
class Effect:
    """An extension of the one model with a neutral value.

    Attributes:
        id: name in the catalogue, such as ``pump_1.leakage``. component, domain: where it acts.
        parameter, unit: the quantity to report.
        reference: value of that quantity without the effect, from the parameter record (1,).
        laws: ways in which the effect may act; each changes a parameter record (1,) in place,
            given the quantity's departure x from ``reference``. At x = 0 none changes anything.
        step: a departure to begin with when the sensitivity is not known.
        lowest, highest: allowed departures. reached: between which machines are, where that is less; a fit may ask for more, but what
            shows only beyond them is not excluded where nothing shows.
        grows: whether it is known for growing, as wear makes it, and a negative departure is rare.
        about: what happens, in one sentence; about_below where the departure is negative and that reads
            otherwise; in both ``{reference}`` stands for what the departure is counted from, see `happens`.
        law: the equation. signature: what it shows in the signals. check: how to see it on the machine.
        confused_with: ids of effects that show alike in common duties and sensors.
        law_error: share of a departure by which the law may misjudge it.
        unsteady: share of its size by which that may be another in each duty, as of heat into a body of which the warmth is not known.
        feigned: departure, standard deviation, that the rig's own law may feign in another duty than that which it was fitted to.
        lacked: quantity of a free run, and its unit, that says what the place lacks without the effect;
            None for the one of its component and domain.
        reading: the signal that errs, of a law that acts in one sensor alone.
        beside: what may have changed along with it since commissioning; None where nothing may.
        title: its name for people, where that is not the id's in words.
    """

    id: str
    component: str
    domain: str
    parameter: str
    unit: str
    reference: Callable[[np.ndarray], float]
    laws: tuple[Apply, ...]
    step: float
    lowest: float = -math.inf
    highest: float = math.inf
    grows: bool = False
    about: str = ""
    about_below: str = ""
    law: str = ""
    signature: str = ""
    check: str = ""
    confused_with: tuple[str, ...] = ()
    law_error: float = 0.0
    unsteady: float = 0.0
    feigned: float = 0.0
    lacked: tuple[str, str] | None = None
    reading: str = ""
    reached: tuple[float, float] = (-math.inf, math.inf)
    beside: Beside | None = None
    title: str = ""

    def happens(self, x: float, commissioned: bool | None = None) -> str:
        """What happens, in one sentence, where the departure is x.

        Args:
            commissioned: whether x is counted from the rig as it was commissioned, or from its sheet; None leaves that open.
        """
        said = self.about_below if x < 0.0 and self.about_below else self.about
        return said.replace("{reference}", _REFERENCES[commissioned])

    @property
    def directions(self) -> tuple[float, ...]:
        """Signs that the departure may have."""
        return tuple(sign for sign in (1.0, -1.0) if (self.highest if sign > 0.0 else -self.lowest) > 0.0)

    def along_with(self, deviations: float) -> Effect:
        """The effect with what changed beside it; whether it departs or not, that has changed then."""
        if self.beside is None or deviations == 0.0:
            return self

        def both(law: Apply, other: Apply) -> Apply:
            def apply(record: np.ndarray, x: float) -> None:
                law(record, x)
                other(record, deviations)

            return apply

        return replace(self, laws=tuple(both(law, self.beside.law) for law in self.laws))

    def limit(self, x: float) -> float:
        """The departure, brought within what is allowed."""
        return min(max(x, self.lowest), self.highest)


Acting = Sequence[tuple[Effect, int, float]]
"""Effects that act: effect, index of its law, departure."""


def apply(acting: Acting, record: np.ndarray) -> np.ndarray:
    """A parameter record (1,), changed in place by all that acts."""
    for effect, law, departure in acting:
        effect.laws[law](record, departure)
    return record


def added(*fields: str) -> Apply:
    """A law that adds the departure to fields of the record."""

    def apply(record: np.ndarray, x: float) -> None:
        for field in fields:
            record[field] += x

    return apply


def scaled(*fields: str) -> Apply:
    """A law that multiplies fields of the record by 1 + departure."""

    def apply(record: np.ndarray, x: float) -> None:
        for field in fields:
            record[field] *= 1.0 + x

    return apply


def divided(*fields: str) -> Apply:
    """A law that divides fields of the record by 1 + departure: a resistance given as a conductance."""

    def apply(record: np.ndarray, x: float) -> None:
        for field in fields:
            record[field] /= 1.0 + x

    return apply


def value_of(field: str) -> Callable[[np.ndarray], float]:
    """Reference that is a field of the record."""
    return lambda record: float(record[field][0])


def fixed(value: float) -> Callable[[np.ndarray], float]:
    """Reference that is a constant: 1 of a ratio, 0 of what is added."""
    return lambda record: value
