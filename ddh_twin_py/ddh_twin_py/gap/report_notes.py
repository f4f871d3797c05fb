"""Notes of a report on what its recordings and the fit of its rig leave open."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from ddh_twin_py.estimation.fitting.calibration import FittedParameter
from ddh_twin_py.gap.diagnosable import Diagnosable
from ddh_twin_py.rig.reader_units import plain, shown

_FIGURES = 4  # of a parameter there
_MOST_AT_END = 4  # parameters named that are pressed against the end of their tolerance


def not_seen(hidden: Sequence[str]) -> list[str]:
    """A note on effects that no signal would show, none where there are none."""
    return [f"can be neither found nor excluded, as no signal of these recordings would show it: {', '.join(hidden)}"] if hidden else []


def pressed_ones(parameters: Sequence[FittedParameter]) -> list[str]:
    """Parameters that a fit pressed against the end of their tolerance, each with its value and that of the sheet."""

    def told(value: float, unit: str) -> str:
        return plain(value * shown(unit).factor, _FIGURES)

    return [f"{p.name} ({told(p.value, p.unit)} instead of {f'{told(p.prior, p.unit)} {shown(p.unit).unit}'.rstrip()})"
            for p in parameters if p.informed and p.at_end]


def at_the_end(pressed: Sequence[str], unwritten: bool, cut: float) -> list[str]:
    """A note on them, none where there are none.

    Args:
        unwritten: a rig file that is written holds other values. cut: tolerances within which parameters are fitted.
    """
    more = f" and {len(pressed) - _MOST_AT_END} further parameters" if len(pressed) > _MOST_AT_END else ""
    are = "are" if len(pressed) > 1 else "is"
    where = "in the fit that comes nearest, which no rig file is written from, " if unwritten else ""
    return [f"{where}{', '.join(pressed[:_MOST_AT_END])}{more} {are} fitted {cut:g} times the tolerance off, the very "
            "end of what a fit may use; the sheet may be wrong there, or something hide behind it"] if pressed else []


def not_held(model: Diagnosable, held: Collection[str]) -> list[str]:
    """A note on what the field recordings hold and held-out data do not, none where nothing is missing."""
    asked = dict.fromkeys(name for own, altered in zip(model.signals, model.altered, strict=True) if altered for name in own)
    missing = [name for name in asked if name not in held]
    return [f"held-out data have no usable {', '.join(missing)}: how near the twin comes to that is not known"] if missing else []
