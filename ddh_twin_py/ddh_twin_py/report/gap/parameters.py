"""Every parameter of the rig that a diagnosis fitted: prior, fitted value, source."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ddh_twin_py.report.calibration.groups import BARELY, WELL
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.units import in_file, number

if TYPE_CHECKING:
    from ddh_twin_py.estimation.fitting.calibration import FittedParameter
    from ddh_twin_py.rig import Rig

_MOST_OPEN = 10
_EFFECT = re.compile(r"^(?:effect .*?|learned, cause unknown), (?=fitted to )")


def parameters_table(parameters: Sequence[FittedParameter], rig: Rig, added: Sequence[str] = (), fit: str = "",
                     source: str = "") -> doc.Html:
    """All parameters, those that moved furthest first, in the units of the rig file, and what the effects ``added`` made of them.

    Args:
        fit: to what they were fitted, in words. source: of their values where the rig holds others; empty where it holds these.
    """
    if not parameters:
        return doc.paragraph("No parameter was fitted.")
    ordered = sorted(parameters, key=lambda p: -abs(p.moved))
    first, rest = ordered[:_MOST_OPEN], ordered[_MOST_OPEN:]
    sources = {p.name: source or _without_effect(rig.quantities[p.name].source) for p in parameters if p.name in rig.quantities}
    usual = Counter(sources.values()).most_common(1)[0][0] if sources else ""
    unusual = {name: said for name, said in sources.items() if said != usual}
    blocks = [
        doc.note(fit) if fit else "",
        doc.note("Units of the rig file. ± is one standard deviation: the prior's is the tolerance of the sheet, the fitted one is what "
                 "the recordings leave of it. Moved: distance from the prior in its standard deviations; beyond 3 is rare."
                 + (f" Source, where no other is named: {usual}." if usual else "")),
        _at_the_end(parameters),
        _written(parameters, rig, added),
        _table(first, unusual),
    ]
    if rest:
        blocks.append(doc.details(f"{len(rest)} further parameters", _table(rest, unusual)))
    return doc.Html("".join(blocks))


def _at_the_end(parameters: Sequence[FittedParameter]) -> doc.Html:
    """Which stand at the end of their tolerance: those that the recordings ask for, which the answer names, and those drawn along."""
    there = [p for p in parameters if p.at_end]
    asked, drawn = ([p.name for p in there if p.informed is told] for told in (True, False))
    said, cut = [], max((p.cut for p in there), default=0.0)
    if asked:
        said.append(f"At {cut:g}, which is as far as a fit may go, and told by the recordings, so that the answer names them: "
                    f"{', '.join(asked)}.")
    if drawn:
        said.append(f"At {cut:g} too" if asked else f"At {cut:g}, which is as far as a fit may go")
        said[-1] += (f", but drawn there along with others, as the recordings say next to nothing of them; the answer does not name them: "
                     f"{', '.join(drawn)}.")
    return doc.note(" ".join(said)) if said else doc.Html("")


def _written(parameters: Sequence[FittedParameter], rig: Rig, added: Sequence[str]) -> doc.Html:
    """What the effects that were added made of the rig's quantities, which is what -o writes; empty where there is nothing."""
    names = [name for name, q in rig.quantities.items() if added and q.source.startswith(("effect ", "learned, "))]
    if not names:
        return doc.Html("")
    fitted = {p.name: p for p in parameters}
    columns = (doc.Column("Parameter", number=False), doc.Column("Unit", number=False), doc.Column("Fitted ± std", "without the effect"),
               doc.Column("In the rig file ± std", "with the effect"), doc.Column("Source", number=False))
    rows = []
    for name in names:
        q, own = rig.quantities[name], fitted.get(name)
        rows.append((name, "" if q.unit == "1" else q.unit, in_file(own.value, own.std) if own else "not fitted",
                     in_file(q.value, q.standard_deviation), q.source))
    table = doc.table(columns, rows, "Quantities on which the effect acts; -o writes them with it")
    return doc.Html(f'<div class="wrap-last">{table}</div>')


def _table(parameters: Sequence[FittedParameter], unusual: Mapping[str, str]) -> doc.Html:
    """Values without any effect; ``unusual`` sources by name."""
    named = any(p.name in unusual for p in parameters)
    columns = (
        doc.Column("Parameter", number=False), doc.Column("Unit", number=False), doc.Column("Prior ± std"), doc.Column("Fitted ± std"),
        doc.Column("Moved", "std of prior"), doc.Column("The recordings say", number=False),
        *([doc.Column("Source", number=False)] if named else []),
    )
    table = doc.table(columns, [
        (p.name, "" if p.unit == "1" else p.unit, in_file(p.prior, p.prior_std), in_file(p.value, p.std), number(p.moved, 2),
         _said(p.share), *([unusual.get(p.name, "")] if named else []))
        for p in parameters
    ])
    return doc.Html(f'<div class="wrap-last">{table}</div>')


def _without_effect(source: str) -> str:
    """Where a value comes from that is told without the effect which the rig's own has in it."""
    return _EFFECT.sub("", source)


def _said(share: float) -> doc.Html:
    if share < WELL:
        return doc.mark("good", "a lot")
    return doc.mark("fair", "a little") if share < BARELY else doc.mark("none", "next to nothing")
