"""What a hypothesis leaves behind: free-form discrepancies of single signals, and how much better they would do.

Every signal may be off by any amount in lifting, lowering and rest, growing with the oil's warmth and with speed; a
temperature by any slow curve. These columns know no physics. The likelihood counts in full here, and every effect may be
present by nearly the noise of its worst signal: under the right hypothesis free forms then gain nothing; where an effect is
in no catalogue, something is left that they take up.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ddh_twin_py.estimation.fitting.binning import STEADY
from ddh_twin_py.estimation.fitting.linear_gaussian import gain
from ddh_twin_py.gap.evidence.hypotheses import WIDTH
from ddh_twin_py.gap.evidence.linearised import Linearised
from ddh_twin_py.gap.evidence.sensitivity import TYPICAL, stacked
from ddh_twin_py.gap.explain.modulation import modulations
from ddh_twin_py.gap.explain.refit import Refitted

_SLACK, _MOST_SLACK = 0.06, 0.15
"""Of the laws, in multiples of an effect's column: what no free form may claim. An effect of several columns has laws that are as many
times as much off; without a commissioning recording that showed them it is the most."""


@dataclass(frozen=True)
class FreeForm:
    """A free-form discrepancy of one signal.

    Attributes:
        signal: name. gain: log evidence that it adds. size: RMS of it, in multiples of the signal's noise.
        depends_on: ``phase``, ``time`` and names of variables, strongest first. phase: where it is largest.
    """

    signal: str
    gain: float
    size: float
    depends_on: list[str]
    phase: str


def free_forms(linearised: Linearised, fitted: Refitted, variables: list[dict[str, np.ndarray]]) -> list[FreeForm]:
    """Free-form discrepancies beside a hypothesis, largest gain first.

    Args:
        fitted: the hypothesis at its optimum. variables: by recording, for every bin of every block in order:
            names of what a discrepancy may grow with, such as ``speed``, to values (rows,).
    """
    comparisons, altered = linearised.comparisons, linearised.model.altered
    own = list(fitted.columns)
    lead = stacked(own, comparisons)
    values = [c.residual(p) + j @ fitted.theta for c, p, j in zip(comparisons, fitted.predictions, linearised.sensitivities, strict=True)]
    names = list(dict.fromkeys(b.signal for c, a in zip(comparisons, altered, strict=True) if a for b in c.blocks))
    columns: list[list[np.ndarray]] = [[] for _ in comparisons]
    groups: list[tuple[str, str, str]] = []
    for name in names:
        parts = [_of_signal(name, c, v if a else None) for c, v, a in zip(comparisons, variables, altered, strict=True)]
        kinds = next(kinds for kinds, _ in parts if kinds)
        for rows, (_, own_columns), comparison in zip(columns, parts, comparisons, strict=True):
            rows.append(own_columns if own_columns is not None else np.zeros((comparison.size, len(kinds))))
        groups += [(name, *kind) for kind in kinds]
    everything = [np.hstack([front, *rows]) for front, rows in zip(lead, columns, strict=True)]
    sums = linearised.basis.otherwise(1.0, _slack(linearised, fitted) / linearised.slack).sums(everything, values)
    k = len(own)
    inner = np.linalg.inv(sums.information[:k, :k] + np.eye(k) / WIDTH**2) if k else np.zeros((0, 0))
    cross = sums.information[:k, k:]
    information = sums.information[k:, k:] - cross.T @ inner @ cross
    score = sums.score[k:] - cross.T @ inner @ sums.score[:k]
    out = []
    for name in names:
        index = np.array([i for i, group in enumerate(groups) if group[0] == name and information[i, i] > 1e-9])
        if not index.size:
            continue
        log, estimate, _ = gain(information[np.ix_(index, index)], score[index], np.full(index.size, WIDTH))
        each = {}
        for i, value in zip(index, estimate, strict=True):
            each.setdefault(groups[i][2], []).append(abs(float(value)))
        phases = {groups[i][1]: abs(float(value)) for i, value in zip(index, estimate, strict=True) if groups[i][2] == "phase"}
        order = sorted(each, key=lambda kind: -float(np.sqrt(np.mean(np.square(each[kind])))))
        out.append(FreeForm(name, float(log), TYPICAL * float(np.sqrt(np.mean(estimate**2))), order,
                            max(phases, key=phases.get) if phases else "all"))
    return sorted(out, key=lambda form: -form.gain)


def _slack(linearised: Linearised, fitted: Refitted) -> float:
    if all(linearised.model.altered):
        return _MOST_SLACK
    largest = max((abs(x / c.x) for c, x in zip(fitted.columns, fitted.x, strict=True)), default=0.0)
    return min(_SLACK * max(1.0, largest), _MOST_SLACK)


def _of_signal(name: str, comparison, variables) -> tuple[list[tuple[str, str]], np.ndarray | None]:
    """Kinds (phase, variable) and columns (rows, m) of one signal, each moving it by `TYPICAL` of its noise."""
    block = next((b for b in comparison.blocks if b.signal == name), None)
    if block is None or variables is None:
        return [], None
    kinds, forms = modulations(block, variables, STEADY)  # what is left while a motion begins or ends is the model's own
    scale = TYPICAL * comparison.noise(name) / block.spread
    out = np.zeros((comparison.size, len(kinds)))
    out[block.rows] = forms * scale[:, None]
    return kinds, out
