"""The next test of a described rig: of those that its engineer names, the one that parts the leading hypotheses."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.real_rigs.diagnose import diagnose
from ddh_twin_py.real_rigs.next_test import DescribedTest
from ddh_twin_py.real_rigs.rig_model import RigModel
from support.heated_block import DESCRIPTION, NOISE, Block

OFFSET, BEND, _ = DESCRIPTION.effects
KNOWN = replace(DESCRIPTION, parameters=tuple(replace(p, std=0.02 * p.std) for p in DESCRIPTION.parameters))
WARMING = 400  # s until the temperature is nearly constant
SAME, WARMER = "Once more.", "Heat it to other temperatures."


def narrow(acting, tests=()):
    """Data at nearly one temperature, where an offset and a bend look alike."""
    rng = np.random.default_rng(0)
    command = np.repeat(2.0 + rng.uniform(-0.05, 0.05, 40), 40)
    blank = Block(command, np.zeros(command.size))
    true = blank.predict(RigModel(KNOWN, [blank]).record(0, np.zeros(2), acting))["temperature"]
    read = np.where(np.arange(true.size) < WARMING, np.nan, true + rng.normal(0.0, NOISE, true.size))
    return RigModel(KNOWN, [Block(command, read)], tests=tests)


@pytest.fixture(scope="module")
def tests():
    same = np.repeat(2.0 + 0.05 * np.sin(np.arange(40)), 40)
    warmer = np.repeat(np.linspace(0.0, 4.0, 40), 40)
    read = np.where(np.arange(same.size) < WARMING, np.nan, 0.0)
    return [DescribedTest(words, Block(command, read, 0.0)) for words, command in ((SAME, same), (WARMER, warmer))]


def test_the_test_that_parts_them_is_named(tests):
    told = diagnose(narrow([(BEND, 0, 0.03)], tests)).diagnosis.report["next_test"]
    assert told is not None and told["description"].startswith(WARMER) and told["expected_separation"] > 3.0
    assert len(told["between"]) >= 2 and {OFFSET.id, BEND.id} <= set(" + ".join(told["between"]).split(" + "))


def test_without_one_the_reason_is_told(tests):
    assert "names no test" in diagnose(narrow([(BEND, 0, 0.03)])).why_no_test()
    useless = diagnose(narrow([(BEND, 0, 0.03)], tests[:1]))
    assert useless.diagnosis.report["next_test"] is None or useless.diagnosis.report["next_test"]["expected_separation"] < 3.0
    plain = diagnose(narrow([], tests))
    assert plain.diagnosis.report["next_test"] is None and "no gap" in plain.why_no_test()
