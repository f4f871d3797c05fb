"""Memory that reading may take: an hour of 100 Hz telemetry in 500 MB."""

import tracemalloc

from ddh_twin_py.bags.reader import read_recording

MESSAGES_OF_AN_HOUR = 730_000


def test_reading_is_frugal(paper_cycle_bag):
    messages = sum(len(s) for _, s in read_recording(paper_cycle_bag).streams())
    tracemalloc.start()
    try:
        read_recording(paper_cycle_bag)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak * MESSAGES_OF_AN_HOUR / messages < 200e6  # beside 170 MB of libraries
