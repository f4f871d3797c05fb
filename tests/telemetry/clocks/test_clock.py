"""What stamps that do not go on say of the unit."""

import pytest
from ddh_twin_py.telemetry.clocks.clock import Break, same_unit


def test_a_clock_that_is_put_back_a_little_leaves_a_unit_as_warm_as_it_is():
    assert same_unit(-10.05) and same_unit(-9.9), "as nodes see 10 s, each by its own streams"
    assert same_unit(-0.6) and same_unit(-3.0) and not same_unit(-60.0) and not same_unit(0.0) and not same_unit(700.0)


@pytest.mark.parametrize(
    ("gap", "broken", "words"),
    [(-3.0, Break.PUT_BACK, "the clock was put back by 3.0 s"), (-60.0, Break.OTHER_TIME, "the stamps jump back by 60.0 s"),
     (700.0, Break.PAUSE, "the stamps go on 700.0 s later")],
)  # fmt: skip
def test_a_break_is_one_for_all_and_has_one_wording(gap, broken, words):
    assert Break.of(gap) is broken and broken.words(gap) == words
