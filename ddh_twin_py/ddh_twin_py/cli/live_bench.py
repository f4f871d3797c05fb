"""What `ddh-twin bench` measures of the live graph."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.bags.writer import write_recording
from ddh_twin_py.benchmarks.figure import Figure
from ddh_twin_py.cli.live_play import play
from ddh_twin_py.cli.live_result import live_result
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.rig import load_rig

_RATE = 3.0


def live_figures(bag: Path, scratch: Path, quick: bool, quiet: bool) -> Iterator[Figure]:
    """The graph at three times real time, and as fast as it goes.

    Args:
        bag: telemetry at 100 Hz; its first minutes are played.
    """
    recording = read_recording(bag)
    for name, rate, duration in (("live at 3 x", _RATE, 60.0 if quick else 180.0),
                                 ("live, flat out", 0.0, 120.0 if quick else 600.0)):
        part, out = scratch / f"part_{rate:g}", scratch / f"out_{rate:g}"
        write_recording(part, recording.between(0.0, duration))
        played = play(part, out, scratch / "nodes.log", rate=rate, quiet=quiet)
        live, share = live_result(out, replay(read_recording(part), load_rig()))
        rate_out = share * live.time.size / recording.between(0.0, duration).duration
        if rate:
            yield Figure(f"{name}, speed", played.speed, "x real time", _RATE, "limit", smaller=False)
            yield Figure(f"{name}, messages lost", played.lost, f"of {played.sent:,}", 0.0, "limit")
            yield Figure(f"{name}, outputs", rate_out, "Hz of data", 20.0, "limit", smaller=False)
            yield Figure(f"{name}, processor", played.cores, "cores", 2.0, "limit")
        else:
            yield Figure(f"{name}", played.speed, "x real time", _RATE, "limit", smaller=False)
            yield Figure(f"{name}, messages", played.speed * played.sent / duration, "messages/s", None)
            yield Figure(f"{name}, messages lost", played.lost, f"of {played.sent:,}", 0.0, "limit")
