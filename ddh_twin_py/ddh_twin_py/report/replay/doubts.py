"""What keeps a replay's free run from being judged, whatever its numbers say."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.estimation.doubts.off_course import off_course
from ddh_twin_py.estimation.left_out import out_of_place
from ddh_twin_py.gap.recordings.contradictions import contradictions
from ddh_twin_py.gap.recordings.doubts import damage
from ddh_twin_py.report.times import starts
from ddh_twin_py.report.units import number
from ddh_twin_py.telemetry.clocks.clock import PUT_BACK, same_unit
from ddh_twin_py.telemetry.recording import Finding, announced_id
from ddh_twin_py.twin.command import SLOWEST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ddh_twin_py.estimation.replay_result import ReplayResult
    from ddh_twin_py.telemetry.recording import Recording

_TELLS_HEAT = 15.0  # s from which a recording says something of temperatures: the filter takes 10 s of them to find where they begin


def doubts(result: ReplayResult) -> tuple[str, ...]:
    """Why the free run may be off, or as good as it looks, through no merit or fault of the twin; empty where nothing is in the way."""
    recording, found = result.recording, []
    if another := result.rig.of_another(announced_id([recording])):
        found.append(another)
    if not commanded(recording):
        found.append("there is no speed command, by which the free run is driven: what it says of anything tells little")
    if not np.isfinite(result.measured["rod_position"]).any():
        found.append("rod position is not read, so that the free run does not know where the rod is: what it says of drive, pressures and "
                     "heat tells little")
    between = float(np.median(np.diff(recording.drive.time))) if recording.drive is not None and len(recording.drive) > 1 else 0.0
    if between > SLOWEST:
        found.append(f"the speed command comes every {number(between, 2)} s and the free run needs it every {SLOWEST:g} s at least: it "
                     "cannot follow the cycle")
    interval = float(np.median(np.diff(result.time))) if result.time.size > 1 else 0.0
    found += [finding.message.removeprefix(f"{recording.path}: ") for finding in off_course(recording, result.time, result.off, interval)]
    begun = starts(result.time)[1:]
    if begun.size:
        times = "once" if begun.size == 1 else f"{begun.size} times"
        gaps = result.time[begun] - result.time[begun - 1] - interval
        found.append(f"the clock jumped back {times}, by {PUT_BACK:g} s or less, and the twin went on as warm as it was"
                     if all(map(same_unit, gaps)) else
                     f"the clock jumped back {times}, and where it did by more than {PUT_BACK:g} s all began anew without knowing its "
                     "temperatures")
    if place := out_of_place(result):
        found.append(place)
    lost = damage([recording])
    more = [f"{len(lost) - 1} further faults of the recording, which ddh-twin info lists"] if len(lost) > 1 else []
    found += [text.removeprefix(f"{recording.path}: ") for text in [*lost[:1], *more, *contradictions(recording, result.rig)]]
    lasting = float(result.time[-1] - result.time[0]) if result.time.size and not begun.size else _TELLS_HEAT
    if lasting < _TELLS_HEAT:
        found.append(f"{number(lasting, 0)} s say next to nothing of temperatures, which take minutes")
    return tuple(found)


def with_doubts(recording: Recording, doubtful: Sequence[str]) -> list[Finding]:
    """A recording's findings, before them a warning of each of its `doubts` that is none of them."""
    told = {finding.message for finding in recording.findings}
    messages = [f"{recording.path}: {text}" for text in doubtful]
    return [*(Finding("warning", recording.path, "", "", None, 1, text) for text in messages if text not in told), *recording.findings]


def commanded(recording: Recording) -> bool:
    """Whether the drive tells any command."""
    return recording.drive is None or bool(np.isfinite(recording.drive.column("speed_command")).any())


def given(recording: Recording) -> str:
    """What a free run is given, in words; what the recording does not tell is the rig file's."""
    ambient = recording.temperatures.get("ambient")
    known = (
        ("speed command", commanded(recording), "no speed command"),
        ("payload", recording.rig is not None and bool(np.isfinite(recording.rig.payload_mass)), "the rig file's payload"),
        ("ambient", ambient is not None and bool(np.isfinite(ambient.values[:, 0]).any()), "the rig file's ambient temperature"),
    )
    command, payload, air = (name if told else otherwise for name, told, otherwise in known)
    return f"{command}, {payload} and {air}"
