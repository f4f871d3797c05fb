"""What "no gap" does not exclude: effects that the recordings would not have shown, or of which they do not tell since when."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.estimation.fitting.calibration import FittedParameter
from ddh_twin_py.gap.explain.detection import SIZES, Detection, detections
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.explain.side_by_side import THREADS
from ddh_twin_py.gap.explain.taken_up import not_shown, shown_since
from ddh_twin_py.gap.words import shown_by_field, tolerance, untold
from ddh_twin_py.rig.reader_units import moved, plus_minus


@dataclass(frozen=True)
class NotExcluded:
    """Effects that may act although no gap is said.

    Attributes:
        since: effects in whose place a parameter stands that only the field recordings show, each with that parameter and its value.
        unsure: effects of which nothing tells whether they act since commissioning, those of ``since`` among them.
        detectable: from which size all others that move any signal would have been found.
        quantities: name of what departs with each of these, by effect.
    """

    since: Mapping[str, str]
    unsure: Sequence[str]
    detectable: Sequence[Detection]
    quantities: Mapping[str, str] = field(default_factory=dict)

    @property
    def missed(self) -> list[Detection]:
        """Effects that neither a moderate size would have shown nor one that machines reach."""
        return [d for d in self.detectable if d.smallest is None or d.rise > SIZES["moderate"] or d.beyond]

    def untold(self) -> dict[str, str]:
        """Effect to why recordings do not tell whether it acts since commissioning; what ``since`` holds first."""
        own = "a value of the rig's own within its tolerance does the same, and the commissioning recording does not show that value"
        return {**{name: shown_by_field(value) for name, value in self.since.items()},
                **{name: own for name in self.unsure if name not in self.since}}

    def notes(self, cut: float) -> list[str]:
        """All of it, a sentence each; ``cut``: tolerances within which parameters are fitted."""
        by_itself = [name for name in self.unsure if name not in self.since]
        said = [f"the rig's own value{tolerance(cut)} explains what {', '.join(by_itself)} would; the commissioning recording does not "
                "show that value, so whether it has changed since cannot be known"] if by_itself else []
        said += [untold({name: value}) for name, value in self.since.items()]
        if self.missed:
            said.append(f"'no gap' does not exclude these, which would likely have been missed even at {SIZES['moderate']:g} times the "
                        f"noise of their worst signal, or as large as machines have them: {', '.join(map(self._with_size, self.missed))}")
        return said

    def _with_size(self, missed: Detection) -> str:
        """An effect with the quantity that departs and the value up or down to which it may act unseen."""
        if missed.smallest is None:
            return f"{missed.effect} (at any size that it may have)"
        name = self.quantities.get(missed.effect, "").replace("_", " ")
        bound = f"{'up' if missed.smallest > 0.0 else 'down'} to {moved(missed.nominal, missed.smallest, missed.unit)}"
        if missed.nominal:  # as finely as the bound
            bound += f", as built {moved(missed.nominal + missed.smallest, -missed.smallest, missed.unit)}"
        return f"{missed.effect} ({f'{name} {bound}'.lstrip()})"


def not_excluded(found: Found, theta: np.ndarray, spread: np.ndarray, parameters: Sequence[FittedParameter]) -> NotExcluded:
    """What recordings without a gap do not exclude.

    Args:
        theta, spread: fitted deviations of the parameters and their standard deviations, (k,). parameters: the same in their units.
    """
    since = _since(found, theta, spread, parameters)
    unsure = list(dict.fromkeys([*_taken_up(found), *since]))
    asked = {column.effect.id: column.effect for column in found.linearised.columns if column.effect.id not in unsure}
    with ThreadPoolExecutor(max_workers=THREADS) as pool:
        seen = detections(found.linearised, list(asked.values()), pool)
    return NotExcluded(since, unsure, seen, {name: effect.parameter for name, effect in asked.items()})


def _taken_up(found: Found) -> list[str]:
    """Effects in whose place the rig's own value, which field recordings alone show, may stand."""
    single = [(ids[0], fitted) for ids, fitted in found.fitted.items() if len(ids) == 1 and not fitted.slight]
    return [name for name, fitted in single if not_shown(found.linearised, fitted)]


def _since(found: Found, theta: np.ndarray, spread: np.ndarray, parameters: Sequence[FittedParameter]) -> dict[str, str]:
    """Effect to the parameter, with its value, that stands in its place and that only the field recordings show; see `shown_since`."""
    shown = shown_since(found.linearised, theta, spread)
    told = {name: parameters[number] for name, number in shown.items() if number < len(parameters)}
    return {name: f"{p.name} {plus_minus(p.value, p.std, p.unit)} instead of the sheet's {plus_minus(p.prior, p.prior_std, p.unit)}"
            for name, p in told.items()}
