"""Time and memory that reading may take: an hour of 100 Hz telemetry in under 5 s and 500 MB."""

import time
import tracemalloc

import pytest
from ddh_twin_py.bags.reader import read_recording

MESSAGES_OF_AN_HOUR = 730_000


@pytest.mark.alone
def test_reading_is_fast(paper_cycle_bag):
    messages = sum(len(s) for _, s in read_recording(paper_cycle_bag).streams())
    times = []
    for _ in range(5):
        start = time.perf_counter()
        read_recording(paper_cycle_bag)
        times.append(time.perf_counter() - start)
    assert min(times) * MESSAGES_OF_AN_HOUR / messages < 2.5  # 0.5 s on an idle 3 GHz core


@pytest.mark.alone
def test_reading_is_frugal(paper_cycle_bag):
    messages = sum(len(s) for _, s in read_recording(paper_cycle_bag).streams())
    tracemalloc.start()
    try:
        read_recording(paper_cycle_bag)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak * MESSAGES_OF_AN_HOUR / messages < 200e6  # beside 170 MB of libraries
