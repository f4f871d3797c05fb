"""A hypothesis whose effects' laws are free: what each does to a signal may be more or less in any phase, at any speed or warmth.

The law of an effect is never quite the rig's. Where two effects explain what one does not, the second is believed for what it
explains beyond such freedom of the first. And a cause that explains a gap only once its law is bent in every regime is not
the cause.

Kennedy & O'Hagan, Bayesian calibration of computer models, J. R. Statist. Soc. B 63 (2001) 425, on the discrepancy of a law.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.explain.modulation import modulations
from ddh_twin_py.gap.explain.refit import Refit, Refitted

_SEEN = 1.0e-6  # squared deviations below which a column moves nothing


class LawFreedom:
    """Freedom of the laws of some effects of one hypothesis.

    Args:
        linearised: the case about one place. fitted: the hypothesis at its optimum.
        free: effects of it whose laws are free, id to the share of its doing by which each form of it is uncertain.

    Attributes:
        none: whether no law has any freedom.
    """

    def __init__(self, linearised: Linearised, fitted: Refitted, free: Mapping[str, float]) -> None:
        variables = linearised.model.variables(linearised.comparisons, fitted.theta, fitted.acting)
        rows = [np.hstack(parts) for parts in zip(*(_forms(linearised, fitted, variables, *item) for item in free.items()), strict=True)]
        seen = sum(np.sum(r**2, axis=0) for r in rows) > _SEEN
        self.none = not seen.any()
        self._refit = None if self.none else Refit(linearised, linearised.basis.with_more([r[:, seen] for r in rows]))

    def log_evidence(self, fitted: Refitted) -> float:
        """Of a hypothesis with that freedom, to be compared with that of others with the same."""
        return fitted.log_evidence if self._refit is None else self._refit.again(fitted).log_evidence


def gain_of_freedom(linearised: Linearised, fitted: Refitted, wider: float) -> float:
    """Log evidence that a hypothesis gains where its effects may do more or less than their laws say, regime by regime.

    Args:
        wider: multiple of `effect.Effect.law_error` by which they may; a law without error, such as a sensor's gain, stays what it is.
    """
    free = {c.effect.id: wider * c.effect.law_error for c in fitted.columns}
    return LawFreedom(linearised, fitted, free).log_evidence(fitted) - fitted.log_evidence


def _forms(linearised: Linearised, fitted: Refitted, variables: Sequence[Mapping[str, np.ndarray]], name: str,
           share: float) -> list[np.ndarray]:
    """A share of what an effect of a hypothesis does to each signal, in every form, by recording, (rows, m)."""
    model = linearised.model
    rest = [acting for acting in fitted.acting if acting[0].id != name]
    made: list[dict[str, np.ndarray]] = []
    for number, (comparison, altered) in enumerate(zip(linearised.comparisons, model.altered, strict=True)):
        own: dict[str, np.ndarray] = {}
        if altered:
            doing = comparison.features(fitted.predictions[number]) - comparison.features(model.run_one(number, fitted.theta, rest))
            for block in comparison.blocks:
                own[block.signal] = modulations(block, variables[number])[1] * (share * doing[block.rows])[:, None]
        made.append(own)
    widths = {signal: forms.shape[1] for own in made for signal, forms in own.items()}
    out = []
    for comparison, own in zip(linearised.comparisons, made, strict=True):
        rows, at = np.zeros((comparison.size, sum(widths.values()))), 0
        places = {block.signal: block.rows for block in comparison.blocks}
        for signal, width in widths.items():
            if signal in own:
                rows[places[signal], at : at + width] = own[signal]
            at += width
        out.append(rows)
    return out
