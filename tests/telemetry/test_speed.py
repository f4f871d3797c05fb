"""Time that screening and alignment may take."""

import time

import numpy as np
import pytest
from ddh_twin_py.telemetry.screening import StreamScreen, screen_recording


def best(repetitions, run):
    times = []
    for _ in range(repetitions):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


@pytest.mark.alone
def test_a_live_chunk_costs_microseconds(noise):
    screen = StreamScreen("drive/telemetry", noise)
    values = np.random.default_rng(1).normal(size=(5, 6))
    stamps = np.arange(5) * 10_000_000
    screen.screen(stamps, values)

    def thousand():
        for k in range(1000):
            screen.screen(stamps + k * 50_000_000, values)

    assert best(5, thousand) / 1000 < 60e-6  # 8 us on an idle 3 GHz core, arrays from Python included


@pytest.mark.alone
def test_a_recording_is_screened_at_once(paper, noise):
    screen_recording(paper, noise)
    assert best(3, lambda: screen_recording(paper, noise)) < 0.3  # 330 s at 100 Hz; 0.03 s when idle
