"""What *no gap* leaves to causes that may act all the same, as the recordings would hardly show them.

Evidence asks about departures that stand out, and its prior leaves out those near none (`hypotheses.weigh`). What may act unseen is counted
here: each effect as likely as before any data, but for the sizes that would have shown.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from scipy.special import expit

from ddh_twin_py.gap.evidence.hypotheses import log_prior
from ddh_twin_py.gap.explain.detection import Detection
from ddh_twin_py.gap.verdict.verdict import UNKNOWN, Verdict, marginal_of

UNLISTED_TOO = 0.34
"""Causes of no catalogue that hide, for each listed one: of 47 answers of no gap on sealed recordings of a commissioned rig that hid
something, 35 hid an effect and 12 what no catalogue lists."""
WITHOUT_COMMISSIONING = 0.2
"""Odds that a listed cause hides where no commissioning recording showed the rig: of 147 such answers 25 hid one. What the tolerances leave
to an effect there is in no size of a signal, so that the odds are the same for all recordings."""


@dataclass(frozen=True)
class Hidden:
    """How likely causes hide, as odds against no effect.

    Attributes:
        listed: effect to these odds. unlisted: of something that no catalogue lists.
    """

    listed: Mapping[str, float]
    unlisted: float


def hidden_causes(detectable: Sequence[Detection], untold: Sequence[str], asked: int, commissioned: bool) -> Hidden:
    """How likely causes hide that these recordings would hardly show.

    Args:
        detectable: from which size effects would have been found. untold: effects in whose place a parameter may stand, and those that move
            no signal at all.
        asked: effects asked about. commissioned: whether a commissioning recording showed the rig.
    """
    if not asked:
        return Hidden({}, 0.0)
    none_first = log_prior((), asked) - log_prior(("",), asked)  # log odds of no effect against one of them, before any data
    missed = dict.fromkeys(untold, 1.0) | {d.effect: _missed(d, none_first) for d in detectable}
    listed = {name: min(1.0, share * math.exp(-none_first)) for name, share in missed.items()}
    if commissioned:
        return Hidden(listed, UNLISTED_TOO * sum(listed.values()))
    whole = sum(listed.values()) or 1.0
    return Hidden({name: WITHOUT_COMMISSIONING * odds / whole for name, odds in listed.items()}, 0.0)


def _missed(detection: Detection, none_first: float) -> float:
    """Probability of no effect where this one acts, over the sizes that its bounds allow; all of it where they allow none that shows."""
    gains = [gain for gain in detection.gain.values() if gain is not None]
    return float(sum(expit(none_first - gain) for gain in gains) / len(gains)) if gains else 1.0


def with_hidden(verdict: Verdict, hidden: Hidden) -> Verdict:
    """A verdict of no gap with what may hide among its sets; that no effect acts stays ahead."""
    sets, none = dict(verdict.sets), verdict.sets[()]
    odds = {(name,): value for name, value in hidden.listed.items()}
    odds[(UNKNOWN,)] = min(hidden.unlisted, 1.0 - sets.get((UNKNOWN,), 0.0) / none)
    for ids, value in odds.items():
        sets[ids] = sets.get(ids, 0.0) + none * value
    whole = sum(sets.values())
    sets = {ids: p / whole for ids, p in sorted(sets.items(), key=lambda item: (-item[1], bool(item[0])))}
    return replace(verdict, sets=sets, effects=marginal_of(sets))
