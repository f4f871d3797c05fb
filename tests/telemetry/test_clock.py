"""What stamps that do not go on say of the unit."""

from ddh_twin_py.telemetry.clock import same_unit


def test_a_clock_that_is_put_back_a_little_leaves_a_unit_as_warm_as_it_is():
    assert same_unit(-10.05) and same_unit(-9.9), "as nodes see 10 s, each by its own streams"
    assert same_unit(-0.6) and same_unit(-3.0) and not same_unit(-60.0) and not same_unit(0.0) and not same_unit(700.0)
