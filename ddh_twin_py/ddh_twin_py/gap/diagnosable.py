"""All that a whole answer asks of a rig's model: the protocol by which any rig can be diagnosed."""

from __future__ import annotations

from typing import Protocol

from ddh_twin_py.gap.contract import NextTest
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.locate.locatable import Locatable
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.verdict import Verdict


class Diagnosable(Locatable, Protocol):
    """A model of which the whole answer can be given."""

    def next_test(self, found: Found, verdict: Verdict, unknown: Unknown) -> NextTest | None:
        """The test that would tell most, None where nothing is left to tell apart or none is known."""
        ...
