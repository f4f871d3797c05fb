"""How a test's design is put into one sentence."""

import numpy as np
import pytest
from ddh_twin_py.gap.design import SIZES, Design, Detection
from ddh_twin_py.report.gap_design_words import verdict


def a_design(seen, classes):
    effects = ("pump_1.leakage", "load.mass", "tank.cooling")
    found = [Detection(e, "1", 0.1, 1.0, "current", dict.fromkeys(SIZES, 5.0 if e in seen else 0.0)) for e in effects]
    return Design(120.0, 600.0, (), True, found, list(effects), np.zeros((3, 3)), classes)


@pytest.mark.parametrize(("seen", "classes", "said"), [
    ((), [], "detects 0 of 3 effects."),
    (("load.mass",), [], "detects 1 of 3 effects."),
    (("load.mass", "tank.cooling"), [], "detects 2 of 3 effects and tells each of them from all others that it detects."),
    (("load.mass", "tank.cooling", "pump_1.leakage"), [["load.mass", "tank.cooling"]],
     "detects 3 of 3 effects; 1 of these is told from every other one that it detects, the others form 1 class."),
])
def test_the_sentence_counts_what_is_detected_and_told_apart(seen, classes, said):
    assert verdict(a_design(seen, classes))[0].endswith(said)
