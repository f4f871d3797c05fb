"""The verdict in one sentence."""

import pytest
from ddh_twin_py.gap.catalogue import EFFECTS
from ddh_twin_py.gap.words import sentence

NO_GAP = {"verdict": "no_gap", "gap": {"as_is": 5.0, "before": 6.0, "after": 1.0}, "hypotheses": [{"effects": [], "probability": 1.0}]}


@pytest.mark.parametrize(("unseen", "ends"), [
    ((), "probability of no effect 100%."),
    (("pump_1.leakage", "line_a.loss"), "no effect 100%, of those that these recordings would show (2 of the catalogue they would not)."),
])  # fmt: skip
def test_no_gap_is_said_of_what_would_show(unseen, ends):
    said = sentence(NO_GAP, EFFECTS, unseen)
    assert said.startswith("No gap: ") and "as given it was 5.0 times" in said and said.endswith(ends)
