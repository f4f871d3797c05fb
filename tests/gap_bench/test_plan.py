"""The plan: seeded, mixed, every effect in turn."""

from collections import Counter

import pytest
from ddh_twin_py.gap_bench.plan import SUITES, PlanError, plan
from ddh_twin_py.plant.listed_faults import LISTED


def test_same_seed_same_plan():
    assert plan(50, 3) == plan(50, 3)
    assert plan(50, 3) != plan(50, 4)


def test_all_suites_and_levels_are_there():
    planned = plan(200, 1)
    assert len({p.name for p in planned}) == 200
    assert {p.suite for p in planned} == set(SUITES)
    assert {p.level for p in planned if p.suite == "single"} == {"clear", "moderate", "faint"}
    assert all(p.hidden == 2 for p in planned if p.suite == "two")
    assert not any(p.commissioning for p in planned if p.suite == "tolerance")
    assert {p.commissioning for p in planned if p.suite == "single"} == {True, False}


def test_every_effect_comes_about_equally_often():
    counted = Counter(p.effects[0] for p in plan(300, 1, ("single",)))
    assert set(counted) == set(LISTED)
    assert max(counted.values()) - min(counted.values()) <= 1


def test_wrong_suite_is_refused():
    with pytest.raises(PlanError, match="suite is 'singel'"):
        plan(3, 1, ("singel",))
    with pytest.raises(PlanError, match="a bench of 0 cases"):
        plan(0, 1)
