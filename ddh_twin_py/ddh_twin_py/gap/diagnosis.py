"""What a diagnosis says, beside the report that its contract names: all that a page shows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ddh_twin_py.estimation.fitting.calibration import FittedParameter
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.contract import Report
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.explain.detection import Detection
from ddh_twin_py.gap.findings import Lack, Shape, Trace
from ddh_twin_py.rig import Rig
from ddh_twin_py.rig.sheet import CUT


@dataclass(frozen=True)
class Weighed:
    """One hypothesis, as an engineer wants to see it weighed.

    Attributes:
        effects: ids, empty for no effect, ``("unknown",)`` for what is in no catalogue.
        probability: of the set. gap_after: with it added, in multiples of the floor, None where not tried.
        values: effect to value, standard deviation, unit and nominal value.
        gains: signal to chi-square that the set explains there (negative: it fits worse than without).
        left: signal to RMS over floor with it added.
    """

    effects: tuple[str, ...]
    probability: float
    gap_after: float | None
    values: Mapping[str, tuple[float, float, str, float | None]]
    gains: Mapping[str, float]
    left: Mapping[str, float]


@dataclass(frozen=True)
class Diagnosis:
    """A diagnosis of one case.

    Attributes:
        report: by the contract's schema, ready for JSON.
        sentence: the verdict with its confidence, for an engineer who reads nothing else.
        recordings: ``commissioning``, ``field``, ``validation`` to paths.
        traces: signal to `Trace`, on held-out data. axes: variables against which residuals may be
            looked at, at the times of each trace: name with unit to (time (m,), values (m,)).
        lacking: what the twin lacks, by place, phase and regime, given the hypotheses.
        alone: the same from the data alone, before any effect is assumed.
        inputs: torque, force, flow and heat left over by the balances of the recording itself.
        added: effects or learned terms with which the gap "after" was taken; empty where parameters alone were fitted anew.
        nameless: whether something acts that the rig holds nothing of, whose parameters are then those known without it.
        damage: what is wrong with the recordings so far that data are lost by it.
        weighed: hypotheses, most probable first. confusable: for each effect of a class, why it cannot be told from the others.
        parameters: of the rig, fitted, with prior, posterior and source (``rig.quantities[name].source``).
        shapes: of what is unknown. rig: with parameters fitted and the winning effect written into it.
        detectable: how large each effect would have to be to be found in these recordings; of no gap alone.
        untold: effect to why these recordings do not tell whether it acts since commissioning; of no gap alone.
        cut: tolerances within which parameters are fitted, infinite where nothing holds them.
        assumptions: texts for the end of the page. seconds: by stage. catalogue: effects by id.
    """

    report: Report
    sentence: str
    recordings: Mapping[str, list[str]]
    traces: Mapping[str, Trace]
    axes: Mapping[str, tuple[np.ndarray, np.ndarray]]
    lacking: list[Lack]
    alone: list[Lack]
    weighed: list[Weighed]
    confusable: Mapping[str, str]
    parameters: list[FittedParameter]
    shapes: list[Shape]
    rig: Rig
    assumptions: list[str] = field(default_factory=list)
    seconds: Mapping[str, float] = field(default_factory=dict)
    catalogue: Mapping[str, Effect] = field(default_factory=lambda: EFFECTS)
    inputs: list[Lack] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)
    added: tuple[str, ...] = ()
    nameless: bool = False
    detectable: list[Detection] = field(default_factory=list)
    untold: Mapping[str, str] = field(default_factory=dict)
    cut: float = CUT

    def gap(self, when: str) -> float:
        """The gap ``as_is``, ``before`` or ``after`` in multiples of the floor, infinite where free runs went astray (null in JSON)."""
        said = self.report["gap"][when]
        return math.inf if said is None else said
