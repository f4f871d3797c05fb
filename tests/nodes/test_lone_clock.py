"""What a model's free run makes of a clock that steps some seconds off the others alone."""

import numpy as np
import pytest
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.nodes.feeds.intervals_feed import IntervalsFeed
from ddh_twin_py.rig import load_rig
from ddh_twin_py.telemetry.alignment.tick_aligner import TickAligner
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.twin.hydraulic_model import HydraulicModel

BEGIN, STEPS, END = 20.0, 30.0, 70.0  # s
AIR = 294.0  # K


@pytest.fixture(scope="module")
def streams(paper_cycle_bag):
    """Of each topic the time in s, stamps and rows of the first seconds."""
    recording = read_recording(paper_cycle_bag)
    cut = {}
    for name, stream in recording.streams():
        kept = (stream.time > BEGIN) & (stream.time < END)
        cut[name] = stream.time[kept], stream.stamps(recording.epoch_ns)[kept], stream.values[kept]
    return cut


def free_run(streams, alone="", off=0.0):
    """Temperatures of the free run by end of interval in ns, K, where one topic's stamps are so many s off from `STEPS` on."""
    aligner = TickAligner({name: values.shape[1] for name, (_, _, values) in streams.items()}, timeout=2.0,
                          awaited=[DRIVE_TOPIC, HYDRAULIC_TOPIC])  # fmt: skip
    feed, model, told = IntervalsFeed(0.05, 3.0), HydraulicModel(load_rig(), AIR), {}

    def advance(ticks, flush=False):
        for batch in feed.add(ticks, flush):
            result = model.advance(batch.measured, batch.command, np.full(len(batch), AIR))
            told.update(zip(batch.end_ns.tolist(), result.free_temperature, strict=True))

    sent = ((at, name, stamp + round(off * 1e9) * (name == alone and at > STEPS), row) for name, (time, stamps, values) in streams.items()
            for at, stamp, row in zip(time.tolist(), stamps.tolist(), values, strict=True))
    for _, name, stamp, row in sorted(sent, key=lambda sample: sample[0]):
        aligner.push(name, stamp, row)
        advance(list(aligner.ready()))
    advance(list(aligner.flush()), flush=True)
    return told


@pytest.fixture(scope="module")
def undisturbed(streams):
    return free_run(streams)


@pytest.mark.parametrize("off", [-4.0, 5.0])
def test_hydraulics_by_another_clock_cost_it_nothing(off, streams, undisturbed):
    disturbed = free_run(streams, HYDRAULIC_TOPIC, off)
    assert set(disturbed) >= set(undisturbed)
    assert max(np.abs(disturbed[end] - told).max() for end, told in undisturbed.items()) < 0.5
