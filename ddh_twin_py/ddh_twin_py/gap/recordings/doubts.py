"""What is doubtful about recordings themselves, said beside whatever a diagnosis finds."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite

import numpy as np

from ddh_twin_py.estimation.fitting.experiment import Experiment
from ddh_twin_py.estimation.fitting.unpredictable import SLIPS
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.telemetry.recording import Recording

_MOST = 6  # notes on one recording
_MOSTLY = 0.5  # share of a topic's samples from which what struck them is told first
_PAUSE = 10.0  # s without any telemetry that are told
_LEAST = 100  # samples that tell something
_AT_STOP, _STANDING, _TURNING = 5.0e-3, 2.0e-3, 10.0  # m from a stop, m/s, rad/s: a rod that stands there while the shaft is told to turn
_PRESSED = 2.0  # s of that which are told
_LEFT_OUT = 2.0  # s that are told of what is not compared


def damage(recordings: Sequence[Recording]) -> list[str]:
    """What reading and screening found wrong so far that data are lost by it, such as a wrong unit, or most samples of a topic."""
    found = []
    for recording in recordings:
        samples = recording.samples()
        most = (f for f in recording.findings if f.severity == "warning" and f.count > _MOSTLY * samples.get(f.topic, inf))
        found += [*(f.message for f in recording.findings if f.severity == "error"), *(f.message for f in most)]
    return found


def pauses(recordings: Sequence[Recording]) -> list[str]:
    """Of recordings in which nothing comes for a while, that this is so and from when to when."""
    found = []
    for recording in recordings:
        time = np.sort(np.concatenate([s.time for s in (recording.drive, recording.hydraulic) if s is not None] or [np.zeros(0)]))
        long = np.flatnonzero(np.diff(time) > _PAUSE)
        if long.size:
            begin, end = time[long[0]], time[long[0] + 1]
            more = f", and {long.size - 1} times more" if long.size > 1 else ""
            found.append(f"{recording.path}: nothing was recorded from {begin:.0f} s to {end:.0f} s{more}; what the machine did then the "
                         "twin does not know, so cut the recording there unless it stood still")
    return found


def left_out(experiments: Sequence[Experiment]) -> list[str]:
    """What of recordings is not compared, for how long and why, where that is more than `_LEFT_OUT` s."""
    return [f"{e.recording.path}: {'rod_velocity' if why == SLIPS else 'what is fast'} is not compared for {seconds:.0f} s of "
            f"{e.duration:.0f} s, in which {why}; no run predicts that to the second"
            for e in experiments for why, seconds in e.left_out.items() if seconds > _LEFT_OUT]


def at_the_stops(recordings: Sequence[Recording], rig: Rig) -> list[str]:
    """Of recordings in which the pumps press the rod against an end stop, that this is so and for how long."""
    found, stroke = [], rig["cylinder.stroke"]
    for recording in recordings:
        drive, hydraulic = recording.drive, recording.hydraulic
        if drive is None or hydraulic is None or len(drive) < _LEAST or len(hydraulic) < _LEAST:
            continue
        position, velocity = hydraulic.column("rod_position"), hydraulic.column("rod_velocity")
        speed = np.interp(hydraulic.time, *_in_order(drive.time, drive.column("speed_command")))
        against = ((position > stroke - _AT_STOP) & (speed > _TURNING)) | ((position < _AT_STOP) & (speed < -_TURNING))
        period = float(np.median(np.diff(np.sort(hydraulic.time))))
        pressed = period * np.count_nonzero(against & (np.abs(velocity) < _STANDING))
        if pressed > _PRESSED:
            found.append(f"{recording.path}: the pumps press the rod against an end stop for {pressed:.0f} s, where pressure, current and "
                         "heat are those of a blocked pump, which the twin knows badly; leave such stretches out")
    return found


def _in_order(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Finite values by time."""
    good = in_order(time, values)
    return (time[good], values[good]) if good.size else (np.zeros(1), np.zeros(1))


def undeclared(recordings: Sequence[Recording], payload: float, matters: bool) -> list[str]:
    """That no usable payload was declared and what was assumed, kg; empty where all declare one.

    Args:
        matters: whether the load may be to blame. Where some declare one it matters anyway: what is assumed of the others is another's.
    """
    silent = [recording.path for recording in recordings if recording.rig is None or not isfinite(recording.rig.payload_mass)]
    if not matters and len(silent) == len(recordings):
        return []
    return [f"{', '.join(silent)}: no usable payload is declared, so that the rig file's {payload:g} kg was assumed"] if silent else []


def of_reference(recordings: Sequence[Recording], rig: Rig) -> list[str]:
    """A question where recordings that name their rig were held against the reference sheet; none where a rig file was given."""
    named = next((r.rig.rig_id for r in recordings if r.rig is not None and r.rig.rig_id), "")
    return [] if rig.named or not named else [
        f"the recordings name {named} and were held against the reference sheet; if {named} is another machine, give its rig file "
        "(--rig)"]


def doubts(recordings: Sequence[Recording]) -> list[str]:
    """What they warn of, what concerns a value first, at most `_MOST` for each recording, then how many more there are.

    What strikes few samples of a topic is counted in one note.
    """
    notes = []
    for recording in recordings:
        slight = recording.slight_findings()
        loud = sorted((f for f in recording.findings if f.severity == "warning" and f not in slight), key=lambda f: not f.field)
        notes += [finding.message for finding in loud[:_MOST]]
        if len(loud) > _MOST:
            notes.append(f"{recording.path}: {len(loud) - _MOST} further warnings; ddh-twin info lists them")
        if slight:
            most = max(slight, key=lambda f: (f.count, bool(f.field)))
            notes.append(f"{recording.path}: {len(slight)} slight warnings, of samples that are missing, late or repeated, at most "
                         f"{most.count} of {recording.samples()[most.topic]} of a topic; ddh-twin info lists them")
    return notes
