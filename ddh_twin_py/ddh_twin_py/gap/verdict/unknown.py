"""What no listed effect explains in the field recordings: how probable, where, how large, on what it depends, its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import expit

from ddh_twin_py.estimation.fitting.binning import PHASES
from ddh_twin_py.gap.contract import Beyond
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.refit import Refitted
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.findings import Shape
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.locate.leftover import FreeForm, free_forms
from ddh_twin_py.gap.model import DescribedModel

UNLISTED = 0.05
"""Probability of something outside the catalogue beside whatever leads: of 157 answers that named an effect with 0.9 or more on sealed
recordings of an independent plant, ten were wrong; of 114 that a commissioned rig has no gap, eleven hid a cause of no catalogue."""
LISTED = 0.05
"""Probability of something listed, or of nothing, however clearly something else is left: of 116 answers of an independent plant that were
told as unknown with 0.97 or more, ten were wrong, all of them of listed causes or none."""
_SOFTNESS = 2.0  # by which log odds are tempered: a free form's gain is no calibrated number
_POINTS = 12  # of a drawn shape


@dataclass(frozen=True)
class Check:
    """What one rule measured beside a hypothesis: its name, the number, and that at which something unknown is as likely as not."""

    name: str
    measured: float
    limit: float


@dataclass(frozen=True)
class Unknown:
    """What is left beside the best listed hypothesis.

    Attributes:
        probability: that something outside the catalogue acts. forms: free forms, largest gain first.
        size, unit: of what is left, as RMS of the largest free form; once its places are known, of what is lacking at the likeliest.
        shapes: drawn. places: where, the likeliest first; see `free_places`.
        off: signal that is off its noise, whatever the rig; see `bin_means`. Empty where none is.
        checks: what the rules measured that were asked about this hypothesis.
    """

    probability: float
    forms: list[FreeForm]
    size: float
    unit: str
    shapes: list[Shape] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    places: list[FreePlace] = field(default_factory=list)
    off: str = ""
    checks: list[Check] = field(default_factory=list)

    @property
    def reading(self) -> str:
        """Signal that errs where the likeliest place is a reading, empty elsewhere."""
        return self.places[0].signal if self.places else ""

    def checked(self, name: str, measured: float, limit: float) -> Unknown:
        """The same, with what a rule measured, unless that is no number."""
        return replace(self, checks=[*self.checks, Check(name, float(measured), float(limit))]) if math.isfinite(measured) else self

    def raised(self, probability: float, note: str) -> Unknown:
        """The same, at least so probable, with a note that says why."""
        return replace(self, probability=max(self.probability, probability), notes=[*self.notes, note])

    def as_doubted_as(self, other: Unknown) -> Unknown:
        """The same, at least as probable as another, with the notes of both."""
        return replace(self, probability=max(self.probability, other.probability), notes=[*self.notes, *other.notes])

    def at_least(self, probability: float, note: str) -> Unknown:
        """The same, at least so probable, with a note that says why where that is as likely as not."""
        if probability <= self.probability:
            return self
        return self.raised(probability, note) if probability >= 0.5 else replace(self, probability=probability)

    def at_most(self, probability: float, note: str) -> Unknown:
        """The same, at most so probable, with a note that says why."""
        return replace(self, probability=min(self.probability, probability), notes=[*self.notes, note])

    def entry(self) -> Beyond:
        """By the contract's schema."""
        return {"component": self.places[0].component, "domain": self.places[0].domain, "size": self.size, "unit": self.unit,
                "depends_on": self.forms[0].depends_on if self.forms else []}


def structure_left(model: DescribedModel, linearised: Linearised, fitted: Refitted) -> bool:
    """Whether a hypothesis leaves something behind that free forms take up."""
    return _judged(linearised, fitted, model.variables(linearised.comparisons, fitted.theta, fitted.acting))[1] > 0.5


def _judged(linearised: Linearised, fitted: Refitted, variables) -> tuple[list[FreeForm], float]:
    """Free forms beside a hypothesis, that which speaks loudest first, and how probable it is that one of them is needed."""
    forms = free_forms(linearised, fitted, variables)
    beyond = {form.signal: form.gain - needed_of(linearised.model, form.signal, fitted) for form in forms}
    forms = sorted(forms, key=lambda form: -beyond[form.signal])
    best = max(beyond.values(), default=-math.inf)
    return forms, float(expit(best / _SOFTNESS))


def needed_of(model: DescribedModel, signal: str, fitted: Refitted) -> float:
    """Log evidence that a free form of a signal must gain beside a hypothesis; see `Witnesses.needed_of`."""
    read = [own[signal].time for own, acts in zip(model.signals, model.altered, strict=True) if acts and signal in own]
    seconds = sum(float(time[-1] - time[0]) for time in read if len(time))
    return model.witnesses.needed_of(signal, len(fitted.columns), not all(model.altered), seconds)


def unknown_beside(model: DescribedModel, found: Found, fitted: Refitted) -> Unknown:
    """Judge what a hypothesis leaves behind.

    Args:
        fitted: the best listed hypothesis, or none, at its optimum.
    """
    linearised = found.linearised
    forms, probability = _judged(linearised, fitted, model.variables(linearised.comparisons, fitted.theta, fitted.acting))
    size, unit, checks = 0.0, "1", []
    if forms:
        signal = model.signals[_reading_it(model, linearised, forms[0])][forms[0].signal]
        size, unit = forms[0].size * signal.noise, signal.unit
        checks = [Check("structure", forms[0].gain, needed_of(model, forms[0].signal, fitted))]
    return Unknown(max(probability, UNLISTED), forms, size, unit, checks=checks)


def drawn(model: DescribedModel, linearised: Linearised, fitted: Refitted, unknown: Unknown) -> Unknown:
    """The same with the shape of what is left beside a hypothesis, of the free form that comes first."""
    if not unknown.forms:
        return unknown
    form = unknown.forms[0]
    number = _reading_it(model, linearised, form)
    variables = model.variables(linearised.comparisons, fitted.theta, fitted.acting)[number]
    named = {f"{name}, {model.variable_units[name]}": values for name, values in variables.items()}
    return replace(unknown, shapes=_shapes(linearised, fitted, named, number, form, model.signals[number][form.signal].unit))


def _reading_it(model: DescribedModel, linearised: Linearised, form: FreeForm) -> int:
    """Number of the first recording in which effects act and that reads a form's signal; of several not all do."""
    return next(i for i, c in enumerate(linearised.comparisons)
                if model.altered[i] and any(block.signal == form.signal for block in c.blocks))


def _shapes(linearised, fitted: Refitted, variables, number: int, form: FreeForm, unit: str) -> list[Shape]:
    """Residual of the free form's signal over each variable, in bins of equal count."""
    comparison = linearised.comparisons[number]
    block = next(b for b in comparison.blocks if b.signal == form.signal)
    left = comparison.residual(fitted.predictions[number])[block.rows] * block.spread
    here = block.binning.phase != PHASES.index("transient")
    out = []
    axes = {**{name: values[block.rows] for name, values in variables.items()}, "time, s": block.binning.time}
    for name, values in axes.items():
        x, y = values[here], left[here]
        edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, _POINTS + 1))) if x.size else np.zeros(0)
        if edges.size < 3:
            continue
        which = np.clip(np.searchsorted(edges, x, "right") - 1, 0, edges.size - 2)
        count = np.bincount(which, minlength=edges.size - 1)
        good = count > 2
        mean = np.bincount(which, y, edges.size - 1)[good] / count[good]
        spread = np.sqrt(np.maximum(np.bincount(which, y**2, edges.size - 1)[good] / count[good] - mean**2, 0.0) / count[good])
        at = np.bincount(which, x, edges.size - 1)[good] / count[good]
        out.append(Shape(name, at, mean, spread, unit, form.signal))
    return out
