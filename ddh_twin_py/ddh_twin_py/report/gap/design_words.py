"""A test's design in words: one sentence on how it comes out, and what is said of each effect."""

from __future__ import annotations

from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.drive.design import Design
from ddh_twin_py.gap.explain.classes import TELLS_APART
from ddh_twin_py.gap.explain.detection import SIZES, Detection
from ddh_twin_py.report.gap.words import effect_name, signal_name
from ddh_twin_py.report.units import duration, number, plus_minus, words

_SURELY = 100.0  # log of the odds that is beyond all doubt


def verdict(design: Design) -> tuple[str, str]:
    """How a test comes out in one sentence, and its level: good, fair or poor."""
    seen = [d for d in design.detections if d.detects("moderate")]
    alone = len(seen) - sum(len(members) for members in design.classes)
    said = f"At a moderate size this test detects {len(seen)} of {len(design.detections)} effects"
    never = sum(d.detects("moderate") is None for d in design.detections)
    if never:
        said += f" ({never} cannot be so large or show nowhere)"
    if design.classes:
        said += (f"; {alone} of these {'is' if alone == 1 else 'are'} told from every other one that it detects, the others form "
                 f"{len(design.classes)} {'class' if len(design.classes) == 1 else 'classes'}")
    elif len(seen) > 1:
        said += " and tells each of them from all others that it detects"
    share = alone / len(design.detections)
    return said + ".", "good" if share > 0.8 else "fair" if share > 0.5 else "poor"


def setting(design: Design) -> str:
    """What is recorded, in words."""
    sensors = ", ".join(words(s) for s in design.sensors) or "none"
    before = f"after a commissioning recording of {duration(design.commissioning)}" if design.commissioning else \
        "without a commissioning recording: the rig is held against its sheet"
    pressures = "both pressures" if design.pressures else "no pressure transducer"
    return f"{duration(design.duration)} of the duty {before}; {pressures}; temperature sensors beside ambient: {sensors}."


def found_at_some_size(d: Detection) -> bool:
    """Whether there is a size that machines reach at which an effect is detected."""
    return d.smallest is not None and not d.beyond


def smallest(d: Detection, short: bool = False) -> str:
    """The smallest departure that is detected, with the quantity's name and the unit that people read; a dash where there is none that
    machines reach.

    Args:
        short: only what a quantity without a unit is, such as `ratio`, instead of every quantity's whole name.
    """
    if not found_at_some_size(d):
        return "–"
    name = words(EFFECTS[d.effect].parameter) if d.effect in EFFECTS else ""
    if short:
        name = name.rpartition(" ")[2] if d.unit == "1" else ""
    return f"{name} {plus_minus(d.smallest, None, d.unit, sign=True)}".lstrip()


def impossible(d: Detection) -> str:
    """Why an effect cannot be as large as that."""
    if d.worst:
        return "beyond bounds"
    return "no such sensor" if d.effect.startswith("sensor.") else "shows nowhere"


def shows_in(d: Detection) -> str:
    """The signal that an effect moves most."""
    return signal_name(d.worst) if d.worst else "no signal"


def nearest(design: Design, d: Detection) -> tuple[str, float] | None:
    """The effect that another is least told from, and by how much; None where that one moves no signal, or is detected at no size."""
    if d.effect not in design.names or len(design.names) < 2 or not found_at_some_size(d):
        return None
    i = design.names.index(d.effect)
    value, other = min((float(value), other) for j, (value, other) in enumerate(zip(design.separation[i], design.names, strict=True))
                       if j != i)
    return other, value


def log_odds(value: float) -> str:
    """The log of the odds as people need it: beyond `_SURELY` it says no more."""
    return f">{_SURELY:g}" if value > _SURELY else number(value, 1)


def separation_words(one: str, other: str, value: float) -> str:
    """One cell of the matrix as a sentence."""
    told = "told apart" if value >= TELLS_APART else "not told apart"
    return f"{effect_name(one)} against {effect_name(other)}: expected log of the odds {log_odds(value)}, {told}"


SIZE_WORDS = {name: f"worst signal rises to {rise:g} times its noise" for name, rise in SIZES.items()}
