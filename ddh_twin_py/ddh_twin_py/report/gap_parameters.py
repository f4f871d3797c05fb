"""Every parameter of the rig that a diagnosis fitted: prior, fitted value, source."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ddh_twin_py.report import document as doc
from ddh_twin_py.report.calibration_groups import BARELY, WELL
from ddh_twin_py.report.units import number

if TYPE_CHECKING:
    from ddh_twin_py.estimation.calibration import FittedParameter
    from ddh_twin_py.rig import Rig

_MOST_OPEN = 10


def parameters_table(parameters: Sequence[FittedParameter], rig: Rig) -> doc.Html:
    """All parameters, those that moved furthest first, in the units of the rig file."""
    if not parameters:
        return doc.paragraph("No parameter was fitted.")
    ordered = sorted(parameters, key=lambda p: -abs(p.moved))
    first, rest = ordered[:_MOST_OPEN], ordered[_MOST_OPEN:]
    blocks = [
        doc.note("Units of the rig file. ± is one standard deviation: the prior's is the tolerance of the sheet, the fitted one is what "
                 "the recordings leave of it. Moved: distance from the prior in its standard deviations; beyond 3 is rare."),
        _table(first, rig),
    ]
    if rest:
        blocks.append(doc.details(f"{len(rest)} further parameters", _table(rest, rig)))
    return doc.Html("".join(blocks))


def _table(parameters: Sequence[FittedParameter], rig: Rig) -> doc.Html:
    columns = (
        doc.Column("Parameter", number=False), doc.Column("Unit", number=False), doc.Column("Prior ± std"), doc.Column("Fitted ± std"),
        doc.Column("Moved", "std of prior"), doc.Column("The recordings say", number=False), doc.Column("Source", number=False),
    )
    table = doc.table(columns, [
        (p.name, "" if p.unit == "1" else p.unit, f"{p.prior:.4g} ± {p.prior_std:.2g}", f"{p.value:.4g} ± {p.std:.2g}", number(p.moved, 2),
         _said(p.share), rig.quantities[p.name].source if p.name in rig.quantities else "")
        for p in parameters
    ])
    return doc.Html(f'<div class="wrap-last">{table}</div>')


def _said(share: float) -> doc.Html:
    if share < WELL:
        return doc.mark("good", "a lot")
    return doc.mark("fair", "a little") if share < BARELY else doc.mark("none", "next to nothing")
