"""Rules by which held-out data, and the fitted ones, make something outside the catalogue more or less probable beside a hypothesis.

Each takes what is unknown beside a hypothesis and gives it back, with another probability and a note that says why. `hearing` says in which
order they act.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit

from ddh_twin_py.gap.shrink.size import of_all
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.witnesses import Witnesses

REFUTED = 0.05
"""Worsening of the gap of held-out data, as a share of it and at least of the floor, from which a hypothesis is refuted."""
REFUTED_AS_RUN = 0.15
"""The same of the gap as run, with a commissioning recording, which the leader's parameters must not spoil either."""
REFUTED_PROBABILITY = 0.7
AWAY, _AS_FAR, _AWAY_SOFTNESS = 1.1, 1.2, 0.12
"""Floors by which the best listed hypothesis may move a signal of held-out data away from what was measured, beyond `_AS_FAR` times what
it was off before, until something unknown is as likely."""
FAR, FAR_PROBABILITY = 3.0, 0.9
"""Multiple of their floor that half of the signals of held-out data may be off, with a commissioning recording, and how surely something is
unknown then."""
OUT_OF_SAMPLE = 1.3
"""Multiple of its floor that a signal must be off on held-out data, for a free form of it to be believed; `FAR` for what a small flaw of
the model moves far."""
_SUMMED_UP = 2.2
"""The same that what sums up small flaws may be off at best beside an effect that closes nearly all of the gap."""
LEFT_BEHIND, LEFT_WITHOUT_COMMISSIONING, _LEFT_SOFTNESS = 2.6, 5.0, 0.2
"""Multiple of its floor that a signal of held-out data may be off beside the best hypothesis, whatever is open of rig and begin, until
something unknown is as likely; the same where no commissioning recording showed how well the laws hold."""
STRAINED, _STRAINED_SOFTNESS = 1.12, 0.02
"""Floors by which a fast signal of a commissioning recording may be off with the parameters that the best listed hypothesis asks for, until
something unknown is as likely: by itself the rig as built is at its floor."""
OFF_ITS_NOISE, _OFF_SOFTNESS = 1.28, 0.03
"""Noises of a mean over a steady stretch by which a signal may be off in the field recordings beside the best listed hypothesis, which the
commissioning recording shows at its noise, until something unknown is as likely."""
DRIFTED, DRIFTED_ALONE, _DRIFT_SOFTNESS, _DRIFT_MOST = 8.0, 5.0, 0.7, 0.8
"""Standard deviations by which the best listed hypothesis may ask for another rig than was commissioned (`drift.Drift.of`), until something
unknown is about as likely; the same of no effect, which has no law that is a little off; how sure that makes it at most."""
DISPLACED, _DISPLACED_SOFTNESS = 1.5, 0.2
"""Standard deviations by which held-out data may ask for another rig or begin than the fitted recordings left open, beyond what is expected
beside a right hypothesis (`held_best.AtBest.displaced`), until something unknown is as likely."""
FREEDOM = 3.0
"""Multiple of an effect's law error by which it may do more or less, signal by signal, in every phase and over speed and warmth."""
BENT, BENT_BY_TWO, BENT_SHARE, _BENT_SOFTNESS = 32.0, 48.0, 0.01, 5.0
"""Log evidence that one effect, and two of which each law has that freedom, may gain by it, and the share of what the hypothesis explains
beyond that, until something unknown is as likely."""
RESIZE = 2.0
"""Multiple of an effect's law error by which its size may be another in another duty, beside what the fit leaves open of it."""
RESIZED, RESIZED_ALONE, _RESIZED_SOFTNESS = 6.5, 25.0, 1.0
"""Squared deviations that held-out data lose with other sizes of two effects that lead, until something unknown is as likely; the same of
one, or of two with hardly a signal in common: a begin that is open or a law that errs in another duty moves their sizes, but they mimic
nothing by a proportion. See `held_best.AtBest.cost`."""
_AS_BUILT = 1.25  # floors: gap of held-out data at which a rig still is as it was commissioned; of 18 sound rigs 17 had 1.2 or less
_CONFIRMED = 1.1  # floors: the same beside a cause whose rig held-out data confirm; beside two right ones 0.99 and 1.00, a wrong one 1.32
_HELPED = 0.8  # share of what a signal was off, below which a hypothesis brings it nearer
_CLOSED = 0.8
"""Share of the gap of held-out data from which the best listed hypothesis is believed instead, where free forms are not."""
_NEARLY_ALL = 0.95  # the same, from which it needs no free form, where these data need none beside it with what is open at its best
_NOT_SEEN, _CLOSED_INSTEAD = 0.4, 0.25  # probabilities that are left of something outside the catalogue
_NO_PROOF = 0.1  # the same, where nothing but a signal speaks that small flaws of laws move far, and nothing showed these


def borne_out(unknown: Unknown, witnesses: Witnesses, needed: Callable[[str], float], left: Mapping[str, float],
              best: Mapping[str, float], closed: float | None, effects: int, built: bool, in_field: Mapping[str, float]) -> Unknown:
    """The same, less probable where held-out data show nothing of what the field recording's free forms speak of.

    They show nothing either where one listed effect closes nearly all of their gap and they need no form beside it, once what is open of
    the rig is at its best: strokes and winding, which sum up small flaws, are then far off as run alone. Of a signal that is at its floor
    in the field recording too, where free forms alone find it off, they say nothing, if a commissioning recording showed that floor.

    Amplified signals bear witness alone only where a commissioning recording showed these laws.

    Args:
        witnesses: of the rig. needed: by a free form of a signal, see `unknown.needed_of`.
        left: of held-out data beside the best listed hypothesis as run, signal to RMS over floor.
        best: the same with what is open of rig and begin at its best.
        closed: share of the gap of held-out data that this hypothesis closes, None where there was none. effects: of which it consists;
            two close much of many a gap. built: whether a commissioning recording showed the laws. in_field: as ``left``, of the field
            recordings.
    """
    loud = [form.signal for form in unknown.forms if form.gain > needed(form.signal)]
    speaking = [signal for signal in loud if signal in left]
    names = ", ".join(speaking)
    if speaking and not built and set(loud) <= set(witnesses.amplified):
        note = (f"the recordings leave structure in {names} alone, which small flaws of the model's laws move far, and "
                "there is no commissioning recording that showed these laws; it is no proof of anything")
        return unknown.at_most(_NO_PROOF, note)
    prompt = [signal for signal in speaking if signal not in witnesses.summing]
    if not speaking or (built and any(in_field.get(signal, 0.0) < OUT_OF_SAMPLE for signal in prompt)):
        return unknown
    alone = closed if effects == 1 and closed is not None else 0.0  # share that one effect closes
    there = f"the field recording leaves structure in {names} beside the best listed hypothesis"
    if all(left[signal] < (FAR if signal in witnesses.amplified else OUT_OF_SAMPLE) for signal in speaking):
        seen = "little" if set(speaking) <= set(witnesses.amplified) else "nothing"
        return unknown.at_most(_CLOSED_INSTEAD if alone >= _CLOSED else _NOT_SEEN, f"{there}, of which held-out data show {seen}")
    least = {signal: _SUMMED_UP if signal in witnesses.summing else OUT_OF_SAMPLE for signal in speaking}
    if built and alone >= _NEARLY_ALL and all(best.get(signal, math.inf) < least[signal] for signal in speaking):
        note = (f"{there}, which closes {100.0 * alone:.0f} % of the gap of held-out data and leaves none of it there, with what is open "
                "of the rig at its best")
        return unknown.at_most(_CLOSED_INSTEAD, note)
    return unknown


def halfway(unknown: Unknown, left: float, closed: float | None, slow: float = 0.0) -> Unknown:
    """The same, more probable where two listed effects together leave much of the gap of held-out data: any two explain a little.

    Args:
        left: gap of held-out data beside them, in multiples of the floor. closed: share of it that they close, None where there was none.
        slow: the largest of the temperatures, which remember an uncertain start: where they are further off than all together, the start
            of these data is to blame and not a third cause.
    """
    if closed is None or closed >= _CLOSED or left < max(OUT_OF_SAMPLE, slow):
        return unknown
    much = f"{100.0 * closed:.0f} %" if closed > 0.0 else "nothing"
    note = (f"with what is open of rig and begin at its best, the two leading effects close {much} of the gap of held-out data and leave "
            f"{left:.1f} times the floor; they are not sure to be all")
    return unknown.raised(_NOT_SEEN, note)


def far_off(unknown: Unknown, left: Mapping[str, float], closed: float | None, effects: int) -> Unknown:
    """The same, sure, where most signals of held-out data are far off beside the best listed hypothesis: no small flaw of laws does that.

    Args:
        left: beside it, RMS over floor of all signals. closed: share of the gap that it closes. effects: of which it consists.
    """
    if not left or (effects and closed is not None and closed >= _CLOSED):
        return unknown
    most = float(np.median(list(left.values())))
    unknown = unknown.checked("far_off", most, FAR)
    if most < FAR:
        return unknown
    best = "beside the best listed hypothesis" if effects else "without any effect"
    note = f"{best} half of the signals of the held-out data are {most:.1f} times their floor off or more; something is left"
    return unknown.raised(FAR_PROBABILITY, note)


def left_behind(unknown: Unknown, left: Mapping[str, float], before: Mapping[str, float],
                floor: Mapping[str, tuple[float, str]], built: bool = True, in_field: Mapping[str, float] | None = None) -> Unknown:
    """The same, more probable where the best listed hypothesis leaves a signal of held-out data off, whatever is open of rig and begin.

    Args:
        left: beside it, RMS over floor of the signals that a run under the true cause follows; see `held_best`.
        before: the same without it and as run; a signal that it brings no nearer may show a flaw of the laws in a duty that nothing else
            showed, and has no say. floor: of each, with its unit. built: whether a commissioning recording showed the laws.
        in_field: beside it in the field recordings; a signal that is as far off there, too, has its say in any case, if a commissioning
            recording showed that it is not so without any effect. Else it has none: free forms asked there what is left, and what they do
            not find is no flaw of a law, such as a rod that sticks and comes free at other moments than the model's.
    """
    limit, there = LEFT_BEHIND if built else LEFT_WITHOUT_COMMISSIONING, in_field or {}

    def has_a_say(name: str, ratio: float) -> bool:
        if built:
            return ratio < _HELPED * before[name] or there.get(name, 0.0) > limit
        return ratio < _HELPED * before[name] and ratio > _AS_FAR * there.get(name, 0.0)

    beyond = {name: ratio - limit for name, ratio in left.items() if has_a_say(name, ratio) and math.isfinite(ratio)}
    worst = max(beyond, key=beyond.get, default="")
    unknown = unknown.checked("left_behind", left[worst], limit) if worst else unknown
    probability = float(expit(beyond[worst] / _LEFT_SOFTNESS)) if worst else 0.0
    if probability <= unknown.probability:
        return unknown
    if probability < 0.5:
        return replace(unknown, probability=probability)
    note = f"beside the best listed hypothesis {worst} of the held-out data is {left[worst]:.1f} times its floor; something is left"
    value, unit = floor[worst]
    size = value * math.sqrt(left[worst] ** 2 - 1.0)
    return replace(unknown.raised(probability, note), size=size, unit=unit)


def strained(unknown: Unknown, prompt: Mapping[str, float], effects: int = 1) -> Unknown:
    """The same, more probable where the best listed hypothesis asks for parameters that the rig as built had not.

    Parameters take up what a wrong cause leaves over, and are fitted to all recordings; what acts only since then leaves a recording of the
    rig as built at its floor.

    Args:
        prompt: RMS over floor beside it of those signals of the commissioning recordings that follow at once. effects: of which the
            hypothesis consists.
    """
    if not prompt:
        return unknown
    worst = max(prompt, key=prompt.get)
    asking = "the best listed hypothesis asks for" if effects else "no effect asks for"
    note = (f"with the parameters that {asking}, {worst} of the commissioning recording is {prompt[worst]:.2f} "
            "times its floor; the rig as built had others")
    unknown = unknown.checked("strained", prompt[worst], STRAINED)
    return unknown.at_least(float(expit((prompt[worst] - STRAINED) / _STRAINED_SOFTNESS)), note)


def off_its_noise(unknown: Unknown, off: Mapping[str, float], effects: int = 1) -> Unknown:
    """The same, more probable where a signal is off in the field recordings beside the best hypothesis that as built was at its noise.

    What is left is of that signal first.

    Args:
        off: of signals in which no law of the rig errs, see `bin_means.beyond_noise`. effects: of which the hypothesis consists.
    """
    worst = max(off, key=off.get, default="")
    unknown = unknown.checked("off_its_noise", off[worst], OFF_ITS_NOISE) if worst else unknown
    probability = float(expit((off[worst] - OFF_ITS_NOISE) / _OFF_SOFTNESS)) if worst else 0.0
    if probability <= 0.5:
        return unknown.at_least(probability, "")
    best = "beside the best listed hypothesis" if effects else "without any effect"
    note = (f"{best} the means of {worst} over steady stretches of the field recording are off by {off[worst]:.1f} times their noise; "
            "in the commissioning recording they are at it")
    forms = sorted(unknown.forms, key=lambda form: form.signal != worst)
    return replace(unknown.raised(probability, note), forms=forms, off=worst)


def drifted(unknown: Unknown, drift: float, effects: int, as_built: float, beside: float) -> Unknown:
    """The same, more probable where the best listed hypothesis asks for another rig than was commissioned.

    That no effect acts is not doubted by it where held-out data are as near to the rig as commissioned as data of that rig are; a cause is
    not where held-out data, which asked for nothing, are at the floor with the rig that it asks for.

    Args:
        drift: see `drift.Drift.of`. effects: of which the hypothesis consists.
        as_built: gap of held-out data with the parameters as commissioned and no effect, in multiples of the floor. beside: the same
            beside the hypothesis, with what is open of rig and begin at its best.
    """
    if (beside <= _CONFIRMED) if effects else (as_built <= _AS_BUILT):
        return unknown
    limit = DRIFTED if effects else DRIFTED_ALONE
    best = "the best listed hypothesis" if effects else "that no effect acts"
    note = (f"{best} fits the recordings only with another rig than the commissioning recording shows ({drift:.0f} standard deviations "
            "beyond what that recording left open)")
    return unknown.checked("drifted", drift, limit).at_least(_DRIFT_MOST * float(expit((drift - limit) / _DRIFT_SOFTNESS)), note)


def displaced(unknown: Unknown, beyond: float) -> Unknown:
    """The same, more probable where held-out data ask for a rig, or a begin, far from what the fitted recordings left open of them.

    What is true leaves them where they were; beside what only mimics it in one duty, another duty moves them.

    Args:
        beyond: standard deviations by which what is open moves farther than is expected, where it is at its best for held-out data but for
            what sums up small flaws; see `held_best.AtBest`.
    """
    note = ("beside the best listed hypothesis the held-out data ask for a rig, or a begin, that the fitted recordings exclude "
            f"({beyond:.0f} standard deviations beyond what they left open)")
    return unknown.checked("displaced", beyond, DISPLACED).at_least(float(expit((beyond - DISPLACED) / _DISPLACED_SOFTNESS)), note)


def bent(unknown: Unknown, gained: float, explained: float, effects: int = 1) -> Unknown:
    """The same, more probable where the best listed hypothesis explains the recordings only with its laws bent from regime to regime.

    Args:
        gained: log evidence by which it is better where they may differ by `FREEDOM`. explained: by which it is better than no effect.
        effects: of which the hypothesis consists.
    """
    note = ("what the best listed hypothesis does to the signals would have to be more in some phases of the cycle, at some speeds or "
            f"temperatures, and less in others than its law says ({gained:.0f} nats of evidence); what is true would not")
    limit = (BENT if effects == 1 else BENT_BY_TWO) + BENT_SHARE * explained
    return unknown.checked("bent", gained, limit).at_least(float(expit((gained - limit) / _BENT_SOFTNESS)), note)


def resized(unknown: Unknown, gained: float, times: Mapping[str, float], spread: Mapping[str, float], proportion: bool) -> Unknown:
    """The same, more probable where held-out data ask for other sizes of the best listed hypothesis: what is true has one size.

    Two effects that mimic a third together do so in the proportion of one duty. Sizes within a deviation of those found say nothing.

    Args:
        gained: squared deviations that these data lose with other sizes, of what sums up small flaws those beyond `FAR`.
        times: effect to the size that they ask for, over that found.
        spread: effect to the standard deviation of that ratio, by what the fit leaves open and by laws that err in another duty (`RESIZE`).
        proportion: whether they are two that could mimic a third in some proportion; see `two_effects.proportioned`.
    """
    if all(abs(ratio - 1.0) <= spread[name] for name, ratio in times.items()):
        return unknown
    asked = " and ".join(f"{name} {ratio:.2f} times as large" for name, ratio in times.items())
    note = f"the held-out data ask for other sizes of the best listed hypothesis ({asked} as found); what is true would be the same in them"
    limit = RESIZED if proportion else RESIZED_ALONE
    return unknown.checked("resized", gained, limit).at_least(float(expit((gained - limit) / _RESIZED_SOFTNESS)), note)


def worsened(unknown: Unknown, witnesses: Witnesses, left: Mapping[str, float], before: Mapping[str, float]) -> Unknown:
    """The same, more probable where the best listed hypothesis moves a signal of held-out data clearly away from what was measured.

    What is true moves none away, whatever else acts; signals that sum up small flaws may go.

    Args:
        witnesses: of the rig. left, before: beside it and without it, RMS over floor.
    """
    away = {name: math.sqrt(max(0.0, left[name] ** 2 - (_AS_FAR * max(1.0, before[name])) ** 2)) for name in left
            if name not in witnesses.summing}
    worst = max(away, key=away.get, default="")
    unknown = unknown.checked("worsened", away[worst], AWAY) if away else unknown
    if not away or away[worst] < 0.5 * AWAY:
        return unknown
    probability = float(expit((away[worst] - AWAY) / _AWAY_SOFTNESS))
    note = (f"the best listed hypothesis moves {worst} of the held-out data from {before[worst]:.1f} to {left[worst]:.1f} times its floor; "
            "what is true would not")
    return unknown.at_least(probability, note)


def refuted(unknown: Unknown, witnesses: Witnesses, ways: Sequence[tuple[Mapping[str, float], Mapping[str, float], float]]) -> Unknown:
    """The same where the best listed hypothesis makes held-out data worse than no effect does: then it is not the cause.

    Signals that sum up small flaws refute nothing by themselves: strokes go their own way where the rod falls by its load
    and not by the pumps' flow.

    Args:
        witnesses: of the rig. ways: in which the data are looked at: multiples of their floor by which signals are off with no effect and
            beside the hypothesis, and the share of the gap that counts as worse.
    """
    asked = [min((_widened(pick(without), pick(left), share) for pick in (dict, witnesses.but_summing)), key=_of_limit)
             for without, left, share in ways]
    worse = [off for off, limit in asked if off >= limit]
    unknown = unknown.checked("refuted", *max(asked, key=_of_limit))
    if not worse:
        return unknown
    note = ("the best listed hypothesis explains the field recording, but makes the held-out data worse by "
            f"{max(worse):.2f} times the floor; it is not believed")
    return unknown.raised(REFUTED_PROBABILITY, note)


def _widened(without: Mapping[str, float], left: Mapping[str, float], share: float) -> tuple[float, float]:
    """Floors by which a gap is widened, and those from which that counts."""
    gap = of_all(without)
    return of_all(left) - gap, share * max(1.0, gap)


def _of_limit(asked: tuple[float, float]) -> float:
    return asked[0] / asked[1]
