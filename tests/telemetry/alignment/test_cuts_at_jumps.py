"""Where the clock of all streams jumps, live and whole recordings are cut alike."""

import numpy as np
import pytest
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.causes import Cause
from ddh_twin_py.telemetry.clocks.clock import clock_segments
from ddh_twin_py.telemetry.recording import Recording, drive_stream, hydraulic_stream, temperature_stream
from ddh_twin_py.telemetry.screening.screening import StreamScreen

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


def late_across(stamps, at, late):
    """The stamps, ns, of which ``late`` ones before number ``at`` come each after a further one behind it."""
    held = list(range(at - late, at) if late < 2 else range(at - late - 1, at - 1))
    rest = [i for i in range(stamps.size) if i not in held]
    for k, i in enumerate(held):
        rest.insert(rest.index(at) + 3 + 2 * k, i)
    return np.array(rest)


@pytest.mark.parametrize("by", [-1_200, -2_000, -9_000, -3600_000])
@pytest.mark.parametrize("late", [0, 1, 4])
def test_what_comes_late_across_a_jump_back_is_of_the_time_before(by, late):
    """As live: one jump, no tick between the two times, each sample in its own."""
    arrived = np.arange(0, 40_000, 20)
    stamps = (arrived + np.where(arrived >= 20_000, by, 0)) * MS + EPOCH
    order = late_across(stamps, 1000, late)
    rows = np.arange(stamps.size * 6, dtype=float).reshape(-1, 6)
    hydraulics = hydraulic_stream((stamps - EPOCH) * 1e-9, rows[:, :4])
    recording = Recording("test", EPOCH, None, drive_stream((stamps[order] - EPOCH) * 1e-9, rows[order]), hydraulics, {})
    whole = align(recording)
    in_order = align(Recording("test", EPOCH, None, drive_stream((stamps - EPOCH) * 1e-9, rows), hydraulics, {}))
    assert whole.restart.sum() == 1
    np.testing.assert_array_equal(whole.end_ns, in_order.end_ns)
    np.testing.assert_array_equal(whole.samples["drive/telemetry"].values, in_order.samples["drive/telemetry"].values)
    screen = StreamScreen("drive/telemetry")
    screen.screen(stamps[order], rows[order])
    assert (screen.segment, screen.count(Cause.CLOCK_JUMP), screen.count(Cause.GAP), screen.count(Cause.OUT_OF_ORDER)) == (1, 1, 0, late)
    told = {0: "", 1: "the first is 0.040 s late", 4: "the first is 0.140 s late"}[late]
    assert any(told in finding.message for finding in screen.findings())
    aligner, live = TickAligner({"drive/telemetry": 6, "hydraulics/telemetry": 4}), []
    for i, k in enumerate(order.tolist()):
        aligner.push("drive/telemetry", int(stamps[k]), rows[k])
        aligner.push("hydraulics/telemetry", int(stamps[i]), rows[i, :4])
        live += aligner.ready()
    live += aligner.flush()
    assert [(tick.end_ns, tick.restart) for tick in live] == list(zip(whole.end_ns.tolist(), whole.restart.tolist(), strict=True))


@pytest.mark.parametrize("by", [-2_000, -3_000])
def test_a_slow_stream_goes_on_after_a_jump_back_by_its_steps(by):
    """Its next stamp is near the last one before the jump, and none comes back from there: it is not late."""
    arrived = np.arange(0, 40_000, 1000)
    stamps = (arrived + np.where(arrived >= 20_000, by, 0)) * MS + EPOCH
    assert clock_segments({"slow": stamps}, 500 * MS)["slow"].tolist() == [0] * 20 + [1] * 20
    screen = StreamScreen("temperature/ambient")
    screen.screen(stamps, np.full((stamps.size, 2), 300.0))
    assert (screen.segment, screen.count(Cause.OUT_OF_ORDER), screen.count(Cause.REPEATED)) == (1, 0, 0)


def test_a_slow_stream_of_which_one_is_late_is_cut_where_others_jump():
    fast = np.concatenate([np.arange(0, 20_000, 20), np.arange(15_000, 30_000, 20), np.arange(28_000, 36_000, 20)])
    slow = np.array([18_400, 19_000, 19_600, 15_100, 19_950, 15_700, 16_300, 27_800, 29_900, 30_000, 32_100])
    assert clock_segments({"fast": fast, "slow": slow}, 500)["slow"].tolist() == [0, 0, 0, 1, 0, 1, 1, 1, 1, 1, 2]
