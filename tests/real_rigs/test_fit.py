"""Fits of a described rig: both ways to the same place, and out of a wrong minimum."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ddh_twin_py.gap.evidence.hypotheses import POWER, POWER_WITHOUT_COMMISSIONING
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.real_rigs.fit import by_steps, fit, least_squares
from ddh_twin_py.real_rigs.rig_model import RigModel
from support.heated_block import DESCRIPTION, Block, block


def test_both_fits_find_what_the_data_were_made_with():
    model = block(theta=(0.8, -0.6), held=False)
    assert least_squares(model) == pytest.approx([0.8, -0.6], abs=0.05)
    assert by_steps(model) == pytest.approx([0.8, -0.6], abs=0.15)


def test_a_fit_may_begin_elsewhere_and_stays_within_its_bounds():
    model = block(theta=(0.8, -0.6), held=False)
    assert least_squares(model, near=np.array([2.0, 2.0]), starts=0) == pytest.approx([0.8, -0.6], abs=0.05)
    with ThreadPoolExecutor(2) as pool:
        assert fit(model, pool, np.array([1.0, 1.0])).theta == pytest.approx([0.8, -0.6], abs=0.15)
    narrow = RigModel(DESCRIPTION.__class__(**{**DESCRIPTION.__dict__, "cut": 0.5}), model.runs)
    assert np.abs(least_squares(narrow)).max() <= 0.5


def test_the_power_is_that_of_the_engine():
    model = block()
    run = Block(model.runs[0].command, model.runs[0].signals["temperature"].measured, 0.0)
    assert Question(model, ()).power == POWER_WITHOUT_COMMISSIONING
    assert Question(RigModel(DESCRIPTION, model.runs, commissioning=[run]), ()).power == POWER
