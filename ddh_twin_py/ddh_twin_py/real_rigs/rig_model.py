"""A described rig with its recordings as the gap engine sees it (`gap.diagnosable.Diagnosable`); for models whose run is cheap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ddh_twin_py.estimation.fitting.calibration import INFORMED, FittedParameter
from ddh_twin_py.estimation.fitting.comparison import Comparison
from ddh_twin_py.gap.effect import Acting, Effect, apply
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.locate.lacking import Course
from ddh_twin_py.gap.locate.leftover import FreeForm
from ddh_twin_py.gap.verdict.verdict import Verdict
from ddh_twin_py.gap.witnesses import Witnesses
from ddh_twin_py.real_rigs.description import Description
from ddh_twin_py.real_rigs.next_test import DescribedTest, next_test
from ddh_twin_py.real_rigs.rig_card import Known, RigCard
from ddh_twin_py.real_rigs.rig_held import RigHeld
from ddh_twin_py.real_rigs.run import Run

_BUILT_IN_WIDTH = 3.0  # how much wider the prior of a built-in effect is than what was believed of it
_ASSUMPTIONS = [
    "Parameters are independent and normal with the priors that the rig's description gives, and the same in all recordings.",
    "Noise is white and of the size that the recordings show at their highest frequencies; laws are a little wrong in every direction.",
    "No more than two effects act at once; what a first round finds is built in before a second one is asked.",
]
_UNCOMMISSIONED = "There is no recording of the rig as built: it is held against its description, and what lies within priors is no gap."


@dataclass(frozen=True)
class BuiltIn:
    """An effect that became part of the model: departure x with standard deviation std, in the effect's unit."""

    effect: Effect
    law: int
    x: float
    std: float


class RigModel:
    """Recordings of one rig and its uncertain parameters; see `gap.diagnosable.Diagnosable`.

    The unknowns are deviations of the parameters in standard deviations of their priors, then those of effects built in.

    Args:
        description: of the rig. runs: recordings whose gap is asked about, to find and fit with. held: recordings that take no part in it
            and may refute; where there are none, samples later than each signal's ``held_from``. built_in: effects that the model has.
        commissioning: recordings of the rig as it should be, to fit with; no effect acts there.
        tests: that can be made, among which the next one is looked for.
    """

    difference = 0.02
    witnesses = Witnesses()

    def __init__(self, description: Description, runs: Sequence[Run], held: Sequence[Run] = (), built_in: Sequence[BuiltIn] = (),
                 commissioning: Sequence[Run] = (), tests: Sequence[DescribedTest] = ()) -> None:
        self.description, self.field, self.held, self.built_in = description, list(runs), list(held), list(built_in)
        self.commissioning, self.tests = list(commissioning), list(tests)
        self.runs = [*self.commissioning, *self.field]
        self.signals = [run.signals for run in self.runs]
        self.altered = [False] * len(self.commissioning) + [True] * len(self.field)
        self.first = len(self.commissioning)
        self.size = len(description.parameters) + len(self.built_in)
        self._base = description.record()
        bounds = [(p.lowest, p.value, p.highest, p.std) for p in description.parameters]
        bounds += [(b.effect.lowest, b.x, b.effect.highest, b.std) for b in self.built_in]
        self._lowest = np.array([max((low - value) / std, -description.cut) for low, value, _, std in bounds])
        self._highest = np.array([min((high - value) / std, description.cut) for _, value, high, std in bounds])
        self.catalogue: Mapping[str, Effect] = {effect.id: effect for effect in description.effects}
        self.assumptions = [*_ASSUMPTIONS, *([] if commissioning else [_UNCOMMISSIONED]), *description.assumptions]
        kinds = {"field": self.field, "commissioning": self.commissioning, "validation": self.held}
        self.recordings = {kind: [run.name for run in own] for kind, own in kinds.items() if own}
        names = self.field[0].variables(self._base)
        self.followed: tuple[str, ...] = ()  # no law of these rigs holds to the floor
        self.kinematic: tuple[str, ...] = ()
        self.cut = description.cut
        self.variable_units = {_plain(name): name.rpartition(", ")[2] for name in names}
        self.rig = RigCard(description.rig, description.source,
                           {p.name: Known(p.value, p.std, p.unit, p.source) for p in description.parameters})

    @property
    def effects(self) -> list[Effect]:
        """Effects of the catalogue that are not built in."""
        there = {b.effect.id for b in self.built_in}
        return [effect for effect in self.description.effects if effect.id not in there]

    def with_effects(self, theta: np.ndarray, acting: Acting, spread: Sequence[float]) -> RigModel:
        """The model with effects built in; their priors are what was believed, `_BUILT_IN_WIDTH` times as wide.

        Args:
            theta: where effects built in before were, (k,). spread: standard deviation of each departure.
        """
        own = theta[len(self.description.parameters):]
        kept = [replace(b, x=b.effect.limit(b.x + float(d) * b.std)) for b, d in zip(self.built_in, own, strict=True)]
        new = [BuiltIn(effect, law, x, _BUILT_IN_WIDTH * max(s, 1e-3 * abs(x))) for (effect, law, x), s in zip(acting, spread, strict=True)]
        return RigModel(self.description, self.field, self.held, kept + new, self.commissioning, self.tests)

    def on(self, runs: Sequence[Run], held: Sequence[Run] = (), commissioning: Sequence[Run] | None = None) -> RigModel:
        """The same model on other recordings; those of commissioning are kept where no others are given."""
        return RigModel(self.description, runs, held, self.built_in, self.commissioning if commissioning is None else commissioning,
                        self.tests)

    def record(self, number: int, theta: np.ndarray, acting: Acting = ()) -> np.ndarray:
        """Parameter record (1,) of a recording; effects, built in or acting, act where it is altered."""
        record = self._base.copy()
        own = len(self.description.parameters)
        for parameter, deviation in zip(self.description.parameters, theta[:own], strict=True):
            record[parameter.name] += deviation * parameter.std
        if not self.altered[number]:
            return record
        for built, deviation in zip(self.built_in, theta[own:], strict=True):
            built.effect.laws[built.law](record, built.x + float(deviation) * built.std)
        return apply(acting, record)

    def _in_question(self, theta: np.ndarray, acting: Acting) -> np.ndarray:
        """Parameter record (1,) of the recordings in question; see `record`."""
        return self.record(self.first, theta, acting)

    def within(self, theta: np.ndarray) -> np.ndarray:
        """Deviations (k,) within the cut of the priors and what laws allow."""
        return np.clip(theta, self._lowest, self._highest)

    def run(self, theta: np.ndarray, acting: Acting = ()) -> list[dict[str, np.ndarray]]:
        """Free run of every recording."""
        return [self.run_one(number, theta, acting) for number in range(len(self.runs))]

    def begin_anew(self, theta: np.ndarray, acting: Acting) -> bool:
        """Nothing changes: where these rigs begin is measured."""
        return False

    def run_one(self, number: int, theta: np.ndarray, acting: Acting = (), roughly: bool = False) -> dict[str, np.ndarray]:
        """Free run of one recording."""
        return self.runs[number].predict(self.record(number, theta, acting))

    def tolerances(self) -> dict[str, float | None]:
        """Of the priors, by field of the record."""
        given = {p.name: p.std for p in self.description.parameters}
        return {name: given.get(name) for name in self._base.dtype.names}

    def variables(self, comparisons: Sequence[Comparison], theta: np.ndarray, acting: Acting = ()) -> list[dict[str, np.ndarray]]:
        """What a discrepancy may depend on, at every bin, by recording."""
        out = []
        for number, (run, comparison) in enumerate(zip(self.runs, comparisons, strict=True)):
            record = self.record(number, theta, acting)
            time = np.concatenate([block.binning.time for block in comparison.blocks])
            out.append({_plain(name): np.interp(time, *axis) for name, axis in run.variables(record).items()})
        return out

    def held_data(self) -> RigHeld:
        """Held runs, or the ends of the others."""
        return RigHeld(self.held, self.field, self._in_question)

    def free_places(self, found: Found, forms: list[FreeForm], off: str = "") -> list[FreePlace]:
        """The place of the signal whose free form gains most."""
        named = (self.description.places[form.signal] for form in forms if form.signal in self.description.places)
        component, domain = next(named, ("rig", "mechanical"))
        return [FreePlace(component, domain, 0.0, 1.0, None)]

    def best_place(self, linearised: Linearised) -> FreePlace | None:
        """None: places of these rigs have no inputs of their own."""
        return None

    def unknown_inputs(self, theta: np.ndarray, spread: np.ndarray) -> list[Lack]:
        """None: these models have no balances of their own."""
        return []

    def learned_terms(self, component: str, domain: str) -> Sequence[Effect]:
        """None: nothing is learned of these rigs."""
        return ()

    def unlisted_laws(self) -> Sequence[Effect]:
        """None: none is known of these rigs."""
        return ()

    def course(self, effect: Effect, without: np.ndarray, acting: np.ndarray) -> Course:
        """Change of the reading of the first recording in question that changes most for its noise."""
        run = self.field[0]
        before, after = run.predict(without), run.predict(acting)
        worst = max(run.signals, key=lambda n: float(np.sqrt(np.mean((after[n] - before[n]) ** 2))) / run.signals[n].noise)
        signal = run.signals[worst]
        phase = np.where(signal.binning.bin >= 0, signal.binning.phase[signal.binning.bin], -1)
        regimes = {(_plain(name), name.rpartition(", ")[2]): np.interp(signal.time, *axis) for name, axis in run.variables(acting).items()}
        return Course(after[worst] - before[worst], signal.unit, phase, regimes)

    def next_test(self, found: Found, verdict: Verdict, unknown: object) -> dict | None:
        """Of the tests that can be made the one that tells the leading listed sets apart best; None where there is none."""
        return None if verdict.word == "no_gap" else next_test(self.tests, self._in_question, found)

    def fitted_parameters(self, theta: np.ndarray, spread: np.ndarray) -> list[FittedParameter]:
        """Parameters, and quantities of effects built in, with prior and posterior."""
        rows = [(p.name, p.unit, p.value, p.std) for p in self.description.parameters]
        for b in self.built_in:
            rows.append((f"{b.effect.id} ({b.effect.parameter})", b.effect.unit, b.effect.reference(self._base) + b.x, b.std))
        return [FittedParameter(name, unit, value, std, value + float(d) * std, float(s) * std, bool(s < INFORMED), self.cut)
                for (name, unit, value, std), d, s in zip(rows, theta, spread, strict=True)]

    def rig_with(self, theta: np.ndarray, acting: Acting, spread: np.ndarray, *, joint: np.ndarray | None = None,
                 as_built: bool = False) -> RigCard:
        """Fitted parameters; quantities of effects that act are added by their ids."""
        told = [run.name for run, altered in zip(self.runs, self.altered, strict=True) if not (as_built and altered)]
        source = f"fitted to {', '.join(told)}"
        known = {p.name: Known(p.value, p.std, p.unit, source) for p in self.fitted_parameters(theta, spread)}
        record = self.record(self.first, theta)
        stds = np.full(len(acting), np.nan) if joint is None else np.sqrt(np.maximum(np.diagonal(joint)[theta.size :], 0.0))
        known |= {effect.id: Known(effect.reference(record) + x, float(std), effect.unit, source)
                  for (effect, _, x), std in zip(acting, stds, strict=True)}
        return RigCard(self.description.rig, self.description.source, known)

    def notes(self) -> list[str]:
        """None of its own."""
        return []


def _plain(name: str) -> str:
    """A variable's name without its unit."""
    return name.rpartition(", ")[0] or name
