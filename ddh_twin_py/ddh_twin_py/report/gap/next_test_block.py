"""The proposed next test on a page: what to do, what it tells apart, and by how much."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ddh_twin_py.gap.next_test.proposal import DECIDES
from ddh_twin_py.report.gap.hypotheses import between
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.units import number


def next_test_block(test: Mapping) -> doc.Html:
    """A test by the contract: ``description``, ``between``, ``expected_separation``."""
    told = between(test.get("between") or [])
    size = test["expected_separation"]
    if size > math.log(1e6):
        odds = "more than a million times as high as before"
    else:
        odds = f"about {math.exp(size):,.0f} times as high as before".replace(",", " ") if size >= DECIDES else "hardly higher than before"
    blocks = [f'<p class="found"><strong>{doc.text(test["description"])}</strong></p>']
    if told:
        blocks.append(doc.paragraph(f"It tells {told}." if size >= DECIDES else f"It would hardly tell {told}."))
    blocks.append(doc.note(f"Expected separation {number(size, 1)}: after it the odds of the right one against the other are expected "
                           f"to be {odds} (log Bayes factor: the natural logarithm of that)."))
    return doc.Html("".join(blocks))
