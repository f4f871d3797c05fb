"""Where the clock of all streams jumps, live and whole recordings are cut alike."""

import numpy as np
import pytest
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.recording import Recording, drive_stream, hydraulic_stream, temperature_stream

EPOCH = 1_772_000_000_000_000_000
MS = 1_000_000
WIDTHS = {"drive/telemetry": 6, "hydraulics/telemetry": 4, "temperature/ambient": 2, "temperature/tank_oil": 2}


def jumping(seed):
    """A recording whose clock jumps up to three times, and its samples in the order in which they came: (recording, (stream, number)).

    Every stream tells between two jumps, which are back by more than messages may be late or the streams' steps, or ahead.
    """
    rng = np.random.default_rng(seed)
    steps = rng.choice([-3600_000, -60_000, -8_000, 7_000, 13_000, 60_000, 700_000, 3600_000], rng.integers(1, 4))
    breaks = np.cumsum(rng.integers(8_000, 15_000, steps.size))
    arrived = []  # (time of arrival, stream, stamp), ms
    for stream, name in enumerate(WIDTHS):
        period = int(rng.choice([10, 20, 50]) if stream < 2 else rng.choice([100, 500, 1000]))
        for at in range(int(rng.integers(1, period + 1)), int(breaks[-1]) + 12_000, period):
            arrived.append((at, name, at + int(steps[breaks < at].sum())))
    arrived.sort()
    stamps = {name: np.array([stamp for _, of, stamp in arrived if of == name], np.int64) for name in WIDTHS}
    values = {name: np.arange(s.size * WIDTHS[name], dtype=float).reshape(s.size, -1) for name, s in stamps.items()}
    drive, hydraulics, *temperatures = ((stamps[name] * 1e-3, values[name]) for name in WIDTHS)
    sensors = {name.removeprefix("temperature/"): temperature_stream(time, rows[:, 0], rows[:, 1])
               for name, (time, rows) in zip(list(WIDTHS)[2:], temperatures, strict=True)}
    seen, order = dict.fromkeys(WIDTHS, 0), []
    for _, name, _ in arrived:
        order.append((name, seen[name]))
        seen[name] += 1
    return Recording("test", EPOCH, None, drive_stream(*drive), hydraulic_stream(*hydraulics), sensors), order


@pytest.mark.parametrize("seed", range(24))
def test_live_and_whole_are_cut_alike_where_the_clock_jumps(seed):
    recording, order = jumping(seed)
    streams = {name: (stream.stamps(EPOCH), stream.values) for name, stream in recording.streams()}
    aligner, live, whole = TickAligner(WIDTHS, awaited=list(WIDTHS)[:2]), [], align(recording)
    for name, i in order:
        aligner.push(name, streams[name][0][i], streams[name][1][i])
        live += aligner.ready()
    live += aligner.flush()
    assert [(tick.end_ns, tick.restart, tick.gap) for tick in live] == [(tick.end_ns, tick.restart, tick.gap) for tick in whole]
    for a, b in zip(live, whole, strict=True):
        for name in WIDTHS:
            np.testing.assert_array_equal(a.samples[name].stamp, b.samples[name].stamp)
            np.testing.assert_array_equal(a.samples[name].values, b.samples[name].values)
