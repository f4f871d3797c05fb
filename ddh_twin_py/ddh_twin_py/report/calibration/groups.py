"""A calibration sorted for people: what was informed, what stays at its prior, which signals agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ddh_twin_py.names import first_of
from ddh_twin_py.report.replay.agreement import FAR, FLOOR, level
from ddh_twin_py.report.units import in_file, words
from ddh_twin_py.rig.sheet import CUT

if TYPE_CHECKING:
    from ddh_twin_py.estimation.fitting.calibration import Calibration, FittedParameter

WELL = 0.5
"""Share of the prior's standard deviation below which a parameter counts as informed."""
BARELY = 0.9
"""Share from which on it stays at its prior; between the two it is partly informed."""
GROUPS = ("informed", "partly informed", "stays at prior", "refused")
_MOST_NAMES = 4
_WORSE = 1.05  # times as far off as before, from which a fit made a signal worse


@dataclass(frozen=True)
class SignalFit:
    """One signal, RMS over the noise of one sample: with the rig as given, with the fit, on the part held out (None: none)."""

    name: str
    before: float
    after: float
    held_out: float | None
    samples_held_out: int

    @property
    def judged(self) -> float:
        """What the agreement is judged by: the part held out where there is one."""
        return self.after if self.held_out is None else self.held_out

    @property
    def worse(self) -> str:
        """That the fit moved it further off what it was fitted to, in brackets; empty where it did not."""
        return f" (made worse by the fit, {self.before:.2f} as given)" if self.after > _WORSE * self.before else ""


def signal_fits(fit: Calibration, held: Mapping[str, tuple[float, int]]) -> list[SignalFit]:
    """The signals of a fit; ``held`` as `estimation.fitting.held_out` gives it, empty where nothing was held out."""
    return [SignalFit(name, fit.before[name], after, *(held[name] if name in held else (None, 0))) for name, after in fit.after.items()]


def group_of(parameter: FittedParameter, fit: Calibration) -> str:
    """One of `GROUPS`."""
    if parameter in fit.refused:
        return "refused"
    return "informed" if parameter.share < WELL else "partly informed" if parameter.share < BARELY else "stays at prior"


def grouped(fit: Calibration) -> dict[str, list[FittedParameter]]:
    """Parameters by group, best informed first."""
    found: dict[str, list[FittedParameter]] = {group: [] for group in GROUPS}
    for parameter in sorted(fit.parameters, key=lambda p: p.share):
        found[group_of(parameter, fit)].append(parameter)
    return found


def asked_for(fit: Calibration) -> str:
    """What came out of the parameters that were asked for, in a sentence; empty where all were fitted."""
    found = {p.name: p for p in fit.parameters if p.name in fit.asked and p not in fit.refused}
    named = [f"{name} {in_file(p.value, p.std)} {'' if p.unit == '1' else p.unit}".rstrip() for name, p in found.items()]
    return f"Fitted: {first_of(named, _MOST_NAMES)}." if named else ""


def unfitted(signals: Sequence[SignalFit]) -> str:
    """That more than half of the signals end beyond `FAR` times noise on what was fitted, in a sentence; empty where they do not."""
    far = [s for s in sorted(signals, key=lambda s: -s.after) if s.after > FAR]
    if 2 * len(far) <= len(signals):
        return ""
    return (f"The fit does not describe this machine: with it {len(far)} of {len(signals)} signals stay more than {FAR:g} times sensor "
            f"noise off on what it was fitted to, {words(far[0].name)} {far[0].after:.0f} times.")


def pressed(fit: Calibration) -> str:
    """The parameters that the fit pressed against the end of their tolerance, in a sentence; empty where it did none."""
    there = [p.name for p in fit.parameters if p.at_end and group_of(p, fit) in ("informed", "partly informed")]
    if not there:
        return ""
    return (f"{first_of(there, _MOST_NAMES)} ended {CUT:g} standard deviations off, which is as far as a fit may go: the sheet may "
            "be wrong there, or something else hide behind it, and their own standard deviations say too little.")


def verdict(fit: Calibration, signals: Sequence[SignalFit], share: float) -> tuple[str, str]:
    """One sentence that says how it came out, and its level (good, fair, poor); a fit that has not settled is not good."""
    where = f"on the last {100 * share:.0f} % of the recordings, held out" if share else "on the recordings it was fitted to"
    far = [s for s in sorted(signals, key=lambda s: -s.judged) if s.judged > FLOOR]
    if not far:
        said, graded = f"The fitted twin's free run is within {FLOOR:g} times sensor noise on all {len(signals)} signals {where}.", "good"
    else:
        named = ", ".join(f"{words(s.name)} {s.judged:.2f}{s.worse}" for s in far[:_MOST_NAMES])
        names = named + (" and more" if len(far) > _MOST_NAMES else "")
        said = f"Beyond {FLOOR:g} times sensor noise {where}: {names} ({len(far)} of {len(signals)} signals)."
        graded = level(far[0].judged)
        if fit.asked:
            said += " What was held at the sheet may be the cause; the standard deviations do not count it."
    said = " ".join(filter(None, (unfitted(signals), asked_for(fit), said)))
    if not fit.settled:
        graded = "fair" if graded == "good" else graded
        said += " The fit was stopped before it had settled."
    if ended := pressed(fit):
        graded = "fair" if graded == "good" else graded
        said += f" {ended}"
    return said, graded
