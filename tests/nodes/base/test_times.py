"""Times in messages."""

import pytest
from builtin_interfaces.msg import Time
from ddh_twin_py.nodes.base.times import ns_of, set_time


@pytest.mark.parametrize("ns", [0, 999_999_999, 1_000_000_000, 1_772_000_000_123_456_789, -1])
def test_a_time_is_told_as_it_was_set(ns):
    time = Time()
    set_time(time, ns)
    assert ns_of(time) == ns and 0 <= time.nanosec < 1_000_000_000
