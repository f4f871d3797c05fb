"""Terms that are learned where no listed effect explains: believed by held-out data alone."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.learned import described, learn
from ddh_twin_py.gap.explain.refit import Refit, Refitted
from ddh_twin_py.gap.explain.search import Found
from support.first_order import EFFECTS, FirstOrder

OFFSET = EFFECTS[2]


@pytest.mark.parametrize(("with_it", "fitted", "before", "is_learned"), [
    (1.0, 3.0, 2.0, True),
    (1.9, 3.0, 2.0, False),  # nearer than the rig fitted to the field, and hardly nearer than as it was built
    (2.9, 3.0, 9.0, False),
])  # fmt: skip
def test_a_term_must_bring_held_out_data_nearer_than_the_rig_as_fitted_and_as_built(with_it, fitted, before, is_learned):
    model = FirstOrder(np.zeros(3), [(OFFSET, 0, 0.2)], seed=2)
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, []), np.zeros(3), pool)
    found = Found(linearised, {(): 1.0}, {(): Refit(linearised).of([], np.zeros(3), np.zeros(0))})
    term = learn(model, found, [OFFSET], lambda fit: with_it if fit.columns else fitted, before)
    assert (term is not None) == is_learned
    if term is not None:
        assert term.effects == (OFFSET.id,) and term.x[0] == pytest.approx(0.2, abs=0.02)


@pytest.mark.parametrize(("unit", "told"), [("1", "(meter.offset +0.058 ± 0.010)"), ("K", "(meter.offset +0.058 ± 0.010 K)"),
                                            ("m", "(meter.offset +58 ± 10 mm)")])  # fmt: skip
def test_what_was_learned_is_told_in_the_units_that_people_read(unit, told):
    column = Column(replace(OFFSET, unit=unit), 0, 1.0, 5.0, "flow", [])
    size = np.array([[0.01**2]])
    fitted = Refitted((column,), np.array([0.058]), size, size, np.zeros(0), [], 0.0, 0.0, np.zeros(1))
    assert described(fitted, 8.0, 1.17) == (
        f"a learned term {told} takes the gap of held-out data, which decided that it is kept, from 8.00 to 1.17 times the floor; it "
        "describes and does not explain")
