"""One effect of which one signal alone tells, and one of which several do."""

from dataclasses import replace

import pytest
from ddh_twin_py.gap.verdict.one_witness import DOUBT, doubted_alone
from ddh_twin_py.gap.verdict.unknown import Unknown
from support.three_signals import fitted, linearised

SURE = Unknown(0.01, [], 0.0, "1")


@pytest.mark.parametrize(("told", "probability"), [((1.0, 0.0, 0.0), DOUBT), ((0.85, 0.15, 0.0), 0.5 * DOUBT), ((0.7, 0.3, 0.0), 0.01)])
def test_the_more_one_signal_bears_of_the_evidence_the_more_it_is_doubted(told, probability):
    found = doubted_alone(SURE, linearised(0.0, [(share, 0.0) for share in told]), fitted(1.0))
    assert found.probability == pytest.approx(probability)
    assert bool(found.notes) == (probability > 0.01)
    assert all("told by pressure" in note for note in found.notes)


def test_what_is_doubted_more_already_stays_so():
    found = doubted_alone(Unknown(0.6, [], 0.0, "1"), linearised(0.0, ((1.0, 0.0), (0.0, 0.0), (0.0, 0.0))), fitted(1.0))
    assert found.probability == 0.6


def test_a_listed_fault_of_a_sensor_speaks_through_it_alone_by_nature():
    alone = fitted(1.0)
    column = alone.columns[0]
    faulty = replace(alone, columns=(replace(column, effect=replace(column.effect, domain="measurement")),))
    assert doubted_alone(SURE, linearised(0.0, ((1.0, 0.0), (0.0, 0.0), (0.0, 0.0))), faulty) is SURE
