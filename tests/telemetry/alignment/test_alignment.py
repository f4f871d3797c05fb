"""Live and array version of the alignment give the same ticks."""

from collections import Counter
from itertools import islice

import numpy as np
import pytest
from ddh_twin_py.telemetry.alignment.recording_ticks import align
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.recording import Recording, drive_stream, hydraulic_stream, temperature_stream
from ddh_twin_py.telemetry.ticks import tick_index
from hypothesis import example, given, settings
from hypothesis import strategies as st

EPOCH = 1_772_000_000_000_000_000  # a multiple of the tick
MS = 1_000_000
WIDTHS = {"drive/telemetry": 6, "hydraulics/telemetry": 4, "temperature/ambient": 2}


def recording_of(arrivals, epoch=EPOCH):
    """A recording with, per stream, stamps in ns after the epoch in order of arrival."""
    streams = []
    for width, stamps in zip(WIDTHS.values(), arrivals, strict=True):
        stamps = np.array(stamps, np.int64)
        values = np.arange(stamps.size * width, dtype=float).reshape(-1, width)
        if width == 6:
            streams.append(drive_stream(stamps * 1e-9, values))
        elif width == 4:
            streams.append(hydraulic_stream(stamps * 1e-9, values))
        else:
            streams.append(temperature_stream(stamps * 1e-9, values[:, 0], values[:, 1]))
    return Recording("test", epoch, None, streams[0], streams[1], {"ambient": streams[2]})


def live_ticks(recording, order, **options):
    """Ticks of the live aligner, fed in the given order of (stream name, index)."""
    aligner = TickAligner(WIDTHS, **options)
    streams = {name: (s.stamps(recording.epoch_ns), s.values) for name, s in recording.streams()}
    ticks = []
    for name, i in order:
        aligner.push(name, streams[name][0][i], streams[name][1][i])
        ticks += aligner.ready()
    ticks += aligner.flush()
    return ticks, aligner


def assert_same(live, whole):
    assert [t.end_ns for t in live] == whole.end_ns.tolist()
    for a, b in zip(live, whole, strict=True):
        assert (a.start_ns, a.end_ns, a.restart, a.gap) == (b.start_ns, b.end_ns, b.restart, b.gap)
        for name in WIDTHS:
            np.testing.assert_array_equal(a.samples[name].stamp, b.samples[name].stamp)
            np.testing.assert_array_equal(a.samples[name].values, b.samples[name].values)


@st.composite
def arrivals(draw):
    """Stamps per stream in order of arrival: late by up to 0.5 s, repeated, with gaps; and a global order."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    lateness = draw(st.sampled_from([0, 20 * MS, 500 * MS, 500 * MS]))
    extreme = draw(st.booleans())  # either in time or as late as allowed
    gap = draw(st.sampled_from([0, 400 * MS, 3_000 * MS]))
    jittered = draw(st.booleans())
    arrived = []  # (time of arrival, stream, stamp)
    for stream, period in enumerate((10 * MS, draw(st.sampled_from([10, 20, 50])) * MS, 500 * MS)):
        count = draw(st.integers(0, 150 if stream < 2 else 6))
        stamps = np.arange(count, dtype=np.int64) * period
        if jittered:
            stamps += rng.integers(0, 3 * MS, count)
        stamps[count // 2 :] += gap
        keep = rng.random(count) > draw(st.sampled_from([0.0, 0.2]))
        stamps = stamps[keep]
        delays = rng.integers(0, 2, stamps.size) * lateness if extreme else rng.integers(0, lateness + 1, stamps.size)
        arrived += [(int(s + d), stream, int(s)) for s, d in zip(stamps, delays, strict=True)]
        again = stamps[rng.random(stamps.size) < 0.1]
        arrived += [(int(s) + int(rng.integers(0, lateness + 1)), stream, int(s)) for s in again]
    arrived.sort()
    per_stream = [[s for _, stream, s in arrived if stream == k] for k in range(3)]
    seen = [0, 0, 0]
    order = []
    for _, stream, _ in arrived:
        order.append((list(WIDTHS)[stream], seen[stream]))
        seen[stream] += 1
    awaited = draw(st.sampled_from([tuple(WIDTHS), ("drive/telemetry", "hydraulics/telemetry"), ("drive/telemetry",)]))
    epoch = EPOCH + draw(st.sampled_from([0, 123_456_789]))
    return per_stream, order, awaited, epoch


@settings(max_examples=150, deadline=None)
@given(arrivals())
@example(([[0, 50 * MS], [], []], [("drive/telemetry", 0), ("drive/telemetry", 1)], ("drive/telemetry",), EPOCH))
def test_live_cuts_are_the_array_cuts(case):
    per_stream, order, awaited, epoch = case
    recording = recording_of(per_stream, epoch)
    live, aligner = live_ticks(recording, order, awaited=awaited)
    assert_same(live, align(recording))
    for name, stream in recording.streams():
        taken = sum(len(t.samples[name]) for t in live)
        assert taken + aligner.counts[name, "duplicate"] == len(stream)
        assert not aligner.counts[name, "late"]


def test_edges_belong_to_the_tick_that_they_end():
    assert tick_index(50 * MS, 50 * MS) == 1
    assert tick_index(50 * MS + 1, 50 * MS) == 2
    assert tick_index(0, 50 * MS) == 0
    assert tick_index(-1, 50 * MS) == 0


def test_edges_are_multiples_of_the_interval():
    ticks = align(recording_of([[3 * MS, 170 * MS], [4 * MS], []]))
    assert (ticks.edges % (50 * MS) == 0).all()
    assert ticks.edges[0] < EPOCH + 3 * MS <= ticks.edges[1]
    assert len(ticks) == 4
    assert not ticks.restart.any()


def test_a_tick_is_held_until_nothing_of_it_can_come():
    aligner = TickAligner(WIDTHS, awaited=["drive/telemetry", "hydraulics/telemetry"])
    for k in range(1, 61):
        aligner.push("drive/telemetry", k * 10 * MS, np.zeros(6))
        if k <= 50:
            aligner.push("hydraulics/telemetry", k * 10 * MS, np.zeros(4))
    assert list(aligner.ready()) == []  # the hydraulic stream stands at 0.50 s
    aligner.push("hydraulics/telemetry", 550 * MS + 1, np.zeros(4))
    (tick,) = aligner.ready()
    assert tick.end_ns == 50 * MS
    assert len(tick.samples["drive/telemetry"]) == 5


def test_a_stopped_stream_is_waited_for_once():
    aligner = TickAligner(WIDTHS, awaited=["drive/telemetry", "hydraulics/telemetry"], timeout=1.0)
    released = []
    for k in range(1, 401):
        aligner.push("drive/telemetry", k * 10 * MS, np.zeros(6))
        if k <= 100:
            aligner.push("hydraulics/telemetry", k * 10 * MS, np.zeros(4))
        released.append(sum(1 for _ in aligner.ready()))
    assert sum(released[:200]) == 9  # up to 0.45 s, until 0.5 s + 0.5 s + 1.0 s
    assert sum(released) == 69  # up to 3.45 s: no longer waited for
    aligner.push("hydraulics/telemetry", 4010 * MS, np.zeros(4))
    tick = next(t for t in aligner.flush() if t.end_ns == 4050 * MS)
    assert len(tick.samples["hydraulics/telemetry"]) == 1


def lagging(lag, period=100 * MS, late=("drive/telemetry", "hydraulics/telemetry"), **options):
    """Ticks of 40 s of which drive and hydraulics come so many s after the temperatures; the aligner, the most samples that it held,
    and of each tick by how many s what had come was ahead of it, (arrival in s, s)."""
    aligner = TickAligner(WIDTHS, awaited=["drive/telemetry", "hydraulics/telemetry"], **options)
    arrivals = [(t + round(lag * 1e9) * (name in late), name, t)
                for name in WIDTHS for t in range(10 * MS, 40_000 * MS, period if "ambient" in name else 10 * MS)]
    ticks, held, behind = [], 0, []
    for at, name, stamp in sorted(arrivals):
        aligner.push(name, stamp, np.zeros(WIDTHS[name]))
        ready = list(aligner.ready())
        ticks += ready
        behind += [(at * 1e-9, (at - tick.end_ns) * 1e-9) for tick in ready]
        held = max(held, sum(len(line.stamps) for line in aligner._lines.values()))
    return ticks + list(aligner.flush()), aligner, held, behind


@pytest.mark.parametrize("period", [100 * MS, 500 * MS, 2_000 * MS])
@pytest.mark.parametrize("lag", [1.5, 3.0, 6.0, 10.0])
def test_streams_that_come_later_than_others_are_waited_for(lag, period):
    ticks, aligner, held, _ = lagging(lag, period, timeout=2.0)
    told = [len(tick.samples[name]) > 0 for tick in ticks if tick.end_ns > lag * 1e9 for name in list(WIDTHS)[:2]]
    assert all(told) and len(told) >= 2 * 600
    assert not any(tick.restart for tick in ticks)
    assert all(count <= 100 * lag for count in aligner.counts.values())  # what was worked off before the streams began
    assert held < 300


@pytest.mark.parametrize("burst", [3, 8])
def test_streams_that_come_with_seconds_at_once_are_waited_for(burst):
    """Of each stream come so many seconds at once, one stream after the other; the first of them tells how far the others will lag."""
    names = ("drive/telemetry", "hydraulics/telemetry")
    aligner, ticks, begin = TickAligner(WIDTHS, timeout=2.0, awaited=names), [], 0
    for _ in range(6):
        for name in names:
            for k in range(begin + 1, begin + burst * 100):
                aligner.push(name, EPOCH + k * 10 * MS, np.zeros(WIDTHS[name]))
            ticks += aligner.ready()
        begin += burst * 100
    ticks += aligner.flush()
    both = [len(tick.samples["hydraulics/telemetry"]) for tick in ticks if len(tick.samples["drive/telemetry"])]
    assert all(both[burst * 20:]), "nothing of it is lost once its lag is known"
    for k in range(begin + 1, begin + 1500):  # one that stops is waited for once, and then no more
        aligner.push("drive/telemetry", EPOCH + k * 10 * MS, np.zeros(6))
        ticks += aligner.ready()
    assert ticks[-1].end_ns > EPOCH + (begin + 1400) * 10 * MS


def test_streams_that_lag_too_far_hold_up_nothing():
    ticks, aligner, held, behind = lagging(20.0, late=("drive/telemetry",), timeout=2.0)
    alone = [tick for tick in ticks if not len(tick.samples["drive/telemetry"])]
    assert len(alone) > 0.7 * len(ticks) and aligner.counts["drive/telemetry", "late"] > 1000
    assert held < 300
    assert max(late for at, late in behind if 20.0 < at < 40.0) < 1.0, "it is not waited for anew with each of its samples"


def test_a_repetition_after_its_tick_is_no_straggler():
    aligner = TickAligner(WIDTHS, awaited=["drive/telemetry"])
    aligner.push("temperature/ambient", 10 * MS, np.zeros(2))
    for k in range(1, 101):
        aligner.push("drive/telemetry", k * 10 * MS, np.zeros(6))
    assert len(list(aligner.ready())) == 9
    aligner.push("temperature/ambient", 10 * MS, np.zeros(2))
    aligner.push("temperature/ambient", 20 * MS, np.zeros(2))
    assert aligner.counts["temperature/ambient", "duplicate"] == 1
    assert aligner.counts["temperature/ambient", "late"] == 1


def test_a_backward_jump_flushes_and_begins_anew():
    stamps = [k * 10 * MS for k in range(1, 101)]
    again = [s - 700 * MS for s in stamps]
    order = [(name, i) for i in range(200) for name in ("drive/telemetry", "hydraulics/telemetry")]
    recording = recording_of([stamps + again, stamps + again, []])
    live, aligner = live_ticks(recording, order)
    assert aligner.counts["drive/telemetry", "clock_jump"] == 1
    assert aligner.counts["hydraulics/telemetry", "clock_jump"] == 0
    assert sum(t.restart for t in live) == 1
    assert sum(len(t.samples["drive/telemetry"]) for t in live) == 200
    assert_same(live, align(recording))


def test_samples_of_the_old_clock_after_a_jump_are_left_out():
    aligner = TickAligner(WIDTHS)
    for k in range(1, 101):
        aligner.push("drive/telemetry", 10**10 + k * 10 * MS, np.zeros(6))
        aligner.push("hydraulics/telemetry", 10**10 + k * 10 * MS, np.zeros(4))
    for k in range(1, 55):  # the reorder window, and twice the usual step of the other that is silent
        aligner.push("drive/telemetry", k * 10 * MS, np.ones(6))
    assert aligner.counts["drive/telemetry", "clock_jump"] == 1
    aligner.push("hydraulics/telemetry", 10**10 + 1010 * MS, np.ones(4))
    aligner.push("hydraulics/telemetry", 12 * MS, np.ones(4))
    ticks = list(aligner.flush())
    assert aligner.counts["hydraulics/telemetry", "old_clock"] == 1
    (first,) = [tick for tick in ticks if tick.restart]
    assert first.end_ns == 50 * MS and first.gap == pytest.approx(-11.05, abs=0.06)
    assert len(first.samples["hydraulics/telemetry"]) == 1


def mixed(apart, seconds=20.0, second_machine=WIDTHS, burst=1):
    """What is left of a machine beside which another one speaks, its clock so many s apart: (its ticks, aligner)."""
    aligner = TickAligner(WIDTHS)
    ticks, waiting = [], []
    for k in range(1, round(seconds * 100)):
        for name, width in WIDTHS.items():
            if name != "temperature/ambient" or k % 50 == 0:
                aligner.push(name, EPOCH + k * 10 * MS, np.zeros(width))
                if name in second_machine:
                    waiting.append((name, EPOCH + round(apart * 1e9) + k * 10 * MS, np.ones(width)))
        if k % burst == 0:
            for sample in waiting:
                aligner.push(*sample)
            waiting = []
        ticks += aligner.ready()
    return ticks + list(aligner.flush()), aligner


@pytest.mark.parametrize("burst", [1, 7])
@pytest.mark.parametrize("apart", [-60.0, 15.0, 60.0, -590.0, -23_444_894.0, 86_400.0])
def test_two_machines_of_different_times_do_not_stop_the_first(apart, burst):
    ticks, aligner = mixed(apart, burst=burst)
    assert len(ticks) == 400 and not any(tick.restart for tick in ticks)
    for name in WIDTHS:
        assert sum(np.count_nonzero(tick.samples[name].values[:, 0] == 0.0) for tick in ticks) == (39 if "ambient" in name else 1999)
        assert aligner.counts[name, "other_clock"] > (35 if "ambient" in name else 1900)
        assert aligner.strayed[name, "other_clock"] == pytest.approx(apart * 1e9, abs=1e9)


def test_a_machine_a_little_ahead_is_gone_on_with_once():
    ticks, aligner = mixed(8.0)
    assert sum(aligner.counts[name, "clock_jump"] for name in WIDTHS) == 0
    assert len(ticks) == 400 + 160


@pytest.mark.parametrize("every", [75, 10])
@pytest.mark.parametrize("runs", [False, True])
@pytest.mark.parametrize("stamp", [0, EPOCH - 3600 * 10**9, EPOCH + 10**18])
def test_one_sensor_by_another_clock_moves_nothing(stamp, runs, every):
    aligner = TickAligner(WIDTHS, awaited=["drive/telemetry", "hydraulics/telemetry"])
    ticks = []
    for k in range(1, 2000):
        for name in ("drive/telemetry", "hydraulics/telemetry", *(("temperature/ambient",) if k % 50 == 0 else ())):
            aligner.push(name, EPOCH + k * 10 * MS, np.zeros(WIDTHS[name]))
        if k % every == 0:
            aligner.push("temperature/ambient", stamp + (k * 10 * MS if runs else 0), np.ones(2))
        ticks += aligner.ready()
    assert len(ticks) > 370 and not any(tick.restart for tick in ticks)
    assert not any((tick.samples["temperature/ambient"].values == 1.0).any() for tick in ticks)
    assert not aligner.counts["temperature/ambient", "clock_jump"]


@pytest.mark.parametrize("ahead", [700, -60])
def test_a_slow_sensor_that_goes_over_to_another_clock_moves_nothing_and_is_named(ahead):
    aligner = TickAligner(WIDTHS, awaited=["drive/telemetry", "hydraulics/telemetry"])
    ticks = []
    for k in range(1, 4000):
        for name in ("drive/telemetry", "hydraulics/telemetry"):
            aligner.push(name, EPOCH + k * 10 * MS, np.zeros(WIDTHS[name]))
        if k % 100 == 0:  # each sample comes more than a reorder window after the one before
            aligner.push("temperature/ambient", EPOCH + k * 10 * MS + (ahead * 10**9 if k > 1000 else 0), np.zeros(2))
        ticks += aligner.ready()
    assert len(ticks) > 770 and not any(tick.restart for tick in ticks)
    assert aligner.counts["temperature/ambient", "other_clock"] >= 20
    assert aligner.strayed["temperature/ambient", "other_clock"] == pytest.approx(ahead * 1e9, abs=2e9)
    assert all(len(tick.samples["drive/telemetry"]) == 5 for tick in ticks[1:-1])


def test_a_clock_that_goes_far_ahead_costs_no_sample_of_any_stream():
    aligner, sent, ticks = TickAligner(WIDTHS), Counter(), []
    for k in range(1, 2000):
        for name, every in zip(WIDTHS, (1, 2, 70), strict=True):
            if k % every == 0:
                aligner.push(name, EPOCH + k * 10 * MS + (700 * 10**9 if k > 1000 else 0), np.zeros(WIDTHS[name]))
                sent[name] += 1
        ticks += aligner.ready()
    ticks += aligner.flush()
    assert [round(tick.gap) for tick in ticks if tick.restart] == [700] and not aligner.counts
    assert {name: sum(len(tick.samples[name]) for tick in ticks) for name in WIDTHS} == sent


def test_a_single_stamp_behind_is_no_jump_and_two_are():
    aligner = TickAligner(WIDTHS)
    for k in range(1, 101):
        for name in ("drive/telemetry", "hydraulics/telemetry"):
            aligner.push(name, EPOCH + k * 10 * MS, np.zeros(WIDTHS[name]))
    aligner.push("drive/telemetry", 0, np.ones(6))
    aligner.push("hydraulics/telemetry", 0, np.ones(4))
    assert len(ticks := list(aligner.flush())) == 20 and not any(tick.restart for tick in ticks)
    aligner.push("hydraulics/telemetry", 1 * MS, np.ones(4))
    first, second = aligner.flush()
    assert first.restart and first.end_ns == 0 and second.end_ns == 50 * MS
    assert [len(tick.samples["hydraulics/telemetry"]) for tick in (first, second)] == [1, 1]
    assert [len(tick.samples["drive/telemetry"]) for tick in (first, second)] == [1, 0]


def test_a_slow_stream_joins_the_new_clock_without_a_jump_of_its_own():
    drive = [k * 10 * MS for k in range(1, 1001)] + [8000 * MS + k * 10 * MS for k in range(1, 1001)]
    ambient = [1000 * MS, 9000 * MS, 15000 * MS]
    recording = recording_of([drive, [], ambient])
    ticks = align(recording)
    assert int(ticks.restart.sum()) == 1
    restart = int(np.flatnonzero(ticks.restart)[0])
    assert ticks.last["temperature/ambient"][restart - 1] == 2
    assert ticks.last["temperature/ambient"][-1] == 3


def test_a_long_silence_is_skipped_and_marked():
    stamps = [10 * MS, 20 * MS, 2000 * 10**9, 2000 * 10**9 + 10 * MS]
    recording = recording_of([stamps, stamps, []])
    order = [(name, i) for i in range(4) for name in ("drive/telemetry", "hydraulics/telemetry")]
    live, _ = live_ticks(recording, order, longest_gap=60.0)
    whole = align(recording, longest_gap=60.0)
    assert_same(live, whole)
    assert int(whole.restart.sum()) == 1
    assert len(whole) == 3  # nothing of the silence, which a clock that was set right looks like


def test_two_sources_on_one_topic_are_refused():
    stamps = [t for k in range(2000) for t in (k * 10 * MS, 10**12 + k * 10 * MS)]
    # of 1999 steps back the first 100 might be messages that came late
    with pytest.raises(ValueError, match="drive/telemetry: the stamps jump back 1899 times, allowed are 1000"):
        align(recording_of([stamps, [], []]))


def test_unknown_awaited_stream_is_named():
    with pytest.raises(ValueError, match="'drve' is none of drive/telemetry"):
        TickAligner(WIDTHS, awaited=["drve"])


SENSORS = ("temperature/tank_oil", "temperature/line_a", "temperature/ambient")
MODELS = ("hydraulics/state", "motor/thermal_state")


def fed_with_models(step, lags, period, bursts, sensors=SENSORS):
    """An aligner over 20 s of data, a clock step back, 20 s more; (pushed after the step, delivered after it, aligner).

    Models tell 50 ms steps `lags` s after the fact; `bursts`: all that is left at once when they see the step.
    """
    aligner = TickAligner(dict.fromkeys(SENSORS + MODELS, 1), timeout=5.0, awaited=MODELS, followers=MODELS)
    clock = lambda t: EPOCH + (t if t <= 20_000 * MS else t - step)  # noqa: E731
    arrivals = [
        (t, 0, name, clock(t)) for k, name in enumerate(sensors) for t in range((37 * k + 1) * MS, 40_000 * MS, period)
    ]
    for name, lag in zip(MODELS, lags, strict=True):
        for t in range(50 * MS, 40_000 * MS + 1, 50 * MS):
            told = min(t + lag, 20_000 * MS + 10 * MS) if bursts and t <= 20_000 * MS else t + lag
            arrivals.append((told, 1, name, clock(t)))
    arrivals.sort()
    pushed, delivered = [], []
    for i, (t, _, name, stamp) in enumerate(arrivals):
        aligner.push(name, stamp, [float(i)])
        if t > 20_000 * MS:
            pushed.append((name, stamp, float(i)))
        for tick in aligner.ready():
            delivered += [(name, s, v[0]) for name in tick.samples for s, v in zip(*samples_of(tick, name), strict=True)]
    for tick in aligner.flush():
        delivered += [(name, s, v[0]) for name in tick.samples for s, v in zip(*samples_of(tick, name), strict=True)]
    return pushed, delivered, aligner


def samples_of(tick, name):
    return tick.samples[name].stamp.tolist(), tick.samples[name].values


@pytest.mark.parametrize("bursts", [False, True])
@pytest.mark.parametrize("period", [100 * MS, 500 * MS, 2_000 * MS])
@pytest.mark.parametrize("step", [0.6, 1.0, 1.5, 2.2, 3.0, 10.0])
def test_a_clock_step_silences_nobody_where_models_lag(step, period, bursts):
    for lags in ((0, 0), (0.4, 0), (1.0, 1.2), (1.2, 3.0), (2.0, 2.0), (4.0, 0.5), (4.0, 4.0)):
        pushed, delivered, aligner = fed_with_models(round(step * 1e9), [round(lag * 1e9) for lag in lags], period, bursts)
        got = set(delivered)
        fresh = EPOCH + 20_000 * MS + 2_000 * MS  # 2 s of data after the place where the clock stepped, by either clock
        lost = [name for name, stamp, number in pushed if stamp > fresh and (name, stamp, number) not in got]
        assert not lost, (lags, len(lost), aligner.counts)
        soon = EPOCH + 20_000 * MS - round(step * 1e9) + 3_000 * MS + (0 if step > 3.0 or period < 2_000 * MS else 2_000 * MS)
        lost = [name for name, stamp, i in pushed if name in SENSORS and stamp > soon and (name, stamp, i) not in got]
        assert not lost, (lags, len(lost), aligner.counts)
        assert sum(aligner.counts[name, "clock_jump"] for name in SENSORS + MODELS) <= 1


@pytest.mark.parametrize("step", [0.6, 1.0, 3.0, 10.0, 3600.0])
def test_without_sensors_the_models_lead(step):
    pushed, delivered, aligner = fed_with_models(round(step * 1e9), (1_000 * MS, 1_200 * MS), 100 * MS, True, sensors=())
    assert sum(aligner.counts[name, "clock_jump"] for name in MODELS) == 1
    got = set(delivered)
    after = [sample for sample in pushed if sample[1] > EPOCH + 20_000 * MS - round(step * 1e9) + 3_000 * MS]
    new = [sample for sample in after if sample[1] <= EPOCH + 18_000 * MS or step < 10.0 and sample[1] > EPOCH + 22_000 * MS]
    assert new and all(sample in got for sample in new)


def test_a_stream_that_never_goes_back_is_heard_again():
    aligner = TickAligner(WIDTHS)
    for k in range(1, 101):
        aligner.push("drive/telemetry", 8 * 10**9 + k * 10 * MS, np.zeros(6))
        aligner.push("hydraulics/telemetry", 8 * 10**9 + k * 10 * MS, np.zeros(4))
    for k in range(1, 201):
        aligner.push("drive/telemetry", k * 10 * MS, np.ones(6))
        if k > 100:  # it was silent for so long that the other's jump was believed
            aligner.push("hydraulics/telemetry", 8 * 10**9 + 1000 * MS + k * 10 * MS, np.ones(4))
    assert aligner.counts["hydraulics/telemetry", "old_clock"] == 51  # the reorder window, then it is its clock


def test_a_sensor_slower_than_the_models_makes_the_jump_known_later():
    aligner = TickAligner({"temperature/ambient": 1, "hydraulics/state": 1}, awaited=["hydraulics/state"],
                          timeout=5.0, followers=["hydraulics/state"])  # fmt: skip
    got = set()
    for t in range(50 * MS, 40_000 * MS, 50 * MS):
        stamp = EPOCH + (t if t <= 21_000 * MS else t - 3600 * 10**9)
        if t % (4_000 * MS) == 0:
            aligner.push("temperature/ambient", stamp, [0.0])
        aligner.push("hydraulics/state", stamp, [float(t)])
        got |= {float(v[0]) for tick in aligner.ready() for v in tick.samples["hydraulics/state"].values}
    assert aligner.counts["temperature/ambient", "clock_jump"] == 1
    assert aligner.counts["hydraulics/state", "clock_jump"] == aligner.counts["hydraulics/state", "old_clock"] == 0
    assert all(float(t) in got for t in range(25_000 * MS, 39_000 * MS, 50 * MS))


def test_sensors_that_stop_where_the_clock_jumps_cost_nothing():
    aligner = TickAligner(dict.fromkeys(SENSORS + MODELS, 1), timeout=5.0, awaited=MODELS, followers=MODELS)
    ticks = []
    for t in range(50 * MS, 40_000 * MS + 1, 50 * MS):
        stamp = EPOCH + (t if t <= 20_000 * MS else t - 20_000 * MS)
        for name in (SENSORS if t <= 20_000 * MS else ()) + MODELS:
            aligner.push(name, stamp, [float(t)])
        ticks += aligner.ready()
    ticks += aligner.flush()
    assert sum(tick.restart for tick in ticks) == 1
    for name in MODELS:
        values = np.concatenate([tick.samples[name].values[:, 0] for tick in ticks])
        missing = np.setdiff1d(np.arange(50, 40_001, 50) * float(MS), values)
        assert np.unique(values).size == values.size  # and only the old clock's last reorder window may be missing
        assert not missing.size or 19_400 * MS < missing.min() and missing.max() <= 20_000 * MS
    assert sum(aligner.counts[name, "clock_jump"] for name in SENSORS + MODELS) == 1


def fused(stamp_of, seconds, looks):
    """Batches of ticks of an aligner beside two models', each of which takes what came, in that order, when it looks: (time in s, ticks).

    ``stamp_of``: time in ns to stamp; ``looks``: nodes look at times in ns.
    """
    drive, names = "drive/telemetry", (*SENSORS, "drive/telemetry")
    upstream = {name: TickAligner(dict.fromkeys(names, 1), timeout=2.0, awaited=[drive]) for name in MODELS}
    fusion = TickAligner(dict.fromkeys(SENSORS + MODELS, 1), timeout=5.0, awaited=MODELS, followers=MODELS)
    periods = [(name, (20 if name == drive else 500) * MS) for name in names]
    arrivals = sorted((t, name) for k, (name, period) in enumerate(periods) for t in range((k + 1) * MS, seconds * 1000 * MS, period))
    told, batches, done = [], [], 0
    for now in looks:
        first, done = done, sum(t <= now for t, _ in arrivals)
        came = arrivals[first:done]
        for name, aligner in upstream.items():
            for t, topic in came:
                aligner.push(topic, stamp_of(t), [0.0])
            told += [(now + 1, name, tick.end_ns) for tick in aligner.ready()]
        waiting = [(t, name, stamp_of(t)) for t, name in came if name != drive] + [entry for entry in told if entry[0] <= now]
        told = [entry for entry in told if entry[0] > now]
        for _, name, stamp in sorted(waiting, key=lambda entry: entry[0]):
            fusion.push(name, stamp, [0.0])
        batches.append((now * 1e-9, list(fusion.ready())))
    return batches, fusion


@pytest.mark.parametrize("busy", [False, True])
@pytest.mark.parametrize(("ahead", "lasts"), [(7200, 20), (30 * 365 * 86_400, 20), (-7200, 20), (7200, 1), (30 * 365 * 86_400, 1)])
def test_a_clock_that_is_wrong_for_a_while_costs_seconds_and_few_ticks(ahead, lasts, busy):
    looks = [t * MS for t in range(300, 60_000, 300) if not busy or not 19_000 < t < 45_000]
    wrong = lambda t: 20_000 * MS < t <= (20 + lasts) * 1000 * MS  # noqa: E731
    batches, fusion = fused(lambda t: EPOCH + t + (ahead * 10**9 if wrong(t) else 0), 60, looks)
    ticks = [tick for _, batch in batches for tick in batch]
    jumps = sum(fusion.counts[name, "clock_jump"] for name in SENSORS + MODELS)
    restarts = sum(tick.restart for tick in ticks)
    assert len(ticks) < (1200 if lasts > 1 else 2200) and max(len(batch) for _, batch in batches) < 1000
    assert (jumps, restarts) == (1, 2) or lasts == 1 and jumps <= 2 and restarts <= 4  # too short to be shown by the sensors
    after = [(now, batch) for now, batch in batches if now > (45 if busy else 20 + lasts) + (4 if lasts > 1 else 8)]
    assert not any(tick.restart for _, batch in after for tick in batch)
    assert all(batch and batch[-1].end_ns > EPOCH + (now - 2.0) * 1e9 for now, batch in after)
    assert all(len(tick.samples[name]) == 1 for _, batch in after for tick in batch for name in MODELS)


def test_a_jump_back_does_not_fill_what_lay_ahead():
    aligner = TickAligner(WIDTHS)
    for start in (0, 500_000, 1_000):  # ms
        for k in range(1, 301):
            for name, width in WIDTHS.items():
                aligner.push(name, EPOCH + (start + 10 * k) * MS, np.zeros(width))
    ticks = list(aligner.flush())
    assert len(ticks) == 180 and [i for i, tick in enumerate(ticks) if tick.restart] == [60, 120]
    assert sum(len(tick.samples["drive/telemetry"]) for tick in ticks) == 900


def test_what_is_taken_a_part_at_a_time_is_the_same():
    recording = recording_of([[k * 10 * MS for k in range(1, 1000)], [], []])
    order = [("drive/telemetry", i) for i in range(999)]
    whole, aligner = live_ticks(recording, order)[0], TickAligner(WIDTHS)
    for name, i in order:
        aligner.push(name, recording.drive.stamps(EPOCH)[i], recording.drive.values[i])
    parts = []
    while part := list(islice(aligner.ready(), 7)):
        parts += part
    parts += aligner.flush()
    assert [tick.end_ns for tick in parts] == [tick.end_ns for tick in whole]


def disordered(delay, step_back=0.0, seed=1, period=20 * MS):
    """Ticks of 40 s with messages up to so many s late at random from 10 to 30 s, the clock s back from 20 s on; and the aligner."""
    rng = np.random.default_rng(seed)
    aligner = TickAligner(WIDTHS, awaited=["drive/telemetry", "hydraulics/telemetry"])
    arrivals = []
    for k, name in enumerate(WIDTHS):
        for t in range((k + 1) * MS, 40_000 * MS, 500 * MS if "ambient" in name else period):
            late = rng.integers(0, round(delay * 1e9) + 1) if 10_000 * MS < t < 30_000 * MS else 0
            arrivals.append((t + int(late), name, EPOCH + t - (round(step_back * 1e9) if t > 20_000 * MS else 0)))
    ticks = []
    for _, name, stamp in sorted(arrivals):
        aligner.push(name, stamp, np.zeros(WIDTHS[name]))
        ticks += aligner.ready()
    return ticks + list(aligner.flush()), aligner


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("period", [1 * MS, 20 * MS, 100 * MS])
def test_messages_that_are_seconds_late_are_dropped_and_named_and_no_clock_jumped(seed, period):
    ticks, aligner = disordered(3.0, seed=seed, period=period)
    assert len(ticks) >= 799 and not any(tick.restart for tick in ticks)
    assert not any(cause == "clock_jump" for _, cause in aligner.counts)
    for name in WIDTHS:
        assert aligner.counts[name, "late"] and not aligner.counts[name, "other_clock"]
        assert -3e9 <= aligner.strayed[name, "late"] < 0


@pytest.mark.parametrize("delay", [0.0, 0.2])
@pytest.mark.parametrize("period", [1 * MS, 20 * MS])
@pytest.mark.parametrize("step", [0.8, 2.0, 4.8, 5.2, 3600.0])
def test_a_clock_that_steps_back_by_seconds_is_found(step, period, delay):
    ticks, aligner = disordered(delay, step, period=period)
    assert sum(aligner.counts[name, "clock_jump"] for name in WIDTHS) == 1
    (restart,) = [tick for tick in ticks if tick.restart]
    assert restart.end_ns == pytest.approx(EPOCH + (20.0 - step) * 1e9, abs=0.3e9)


@pytest.mark.parametrize("calm", [30, 200])
def test_a_lag_of_long_ago_makes_nobody_wait_longer(calm):
    """One stream comes 6 s late once, goes on in time for so many s, and stops."""
    aligner = TickAligner(WIDTHS, timeout=2.0, awaited=["drive/telemetry", "hydraulics/telemetry"])
    ticks, kept = [], []
    for k in range(1, 50 * (20 + calm + 20)):
        stamp, t = EPOCH + k * 20 * MS, 0.02 * k
        aligner.push("drive/telemetry", stamp, np.zeros(6))
        if t < 20 + calm:
            kept.append(stamp)
        if not 10 < t < 16:
            for late in kept:
                aligner.push("hydraulics/telemetry", late, np.zeros(4))
            kept = []
        ticks += aligner.ready()
        if t < 20 + calm:
            stopped = len(ticks)
        elif len(ticks) == stopped:
            waited = t - 20 - calm
    assert waited == pytest.approx(2.0 if calm > 120 else 8.0, abs=1.0)
