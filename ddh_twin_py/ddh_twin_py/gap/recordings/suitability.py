"""Whether recordings allow a diagnosis, and what they cannot tell whatever is found."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ddh_twin_py.estimation.fitting.binning import HOLDING
from ddh_twin_py.estimation.fitting.experiment import Experiment, ExperimentError
from ddh_twin_py.estimation.fitting.unpredictable import COMMANDS_LOST
from ddh_twin_py.gap.effect import Effect
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.recordings.contradictions import other_clock
from ddh_twin_py.gap.recordings.two_machines import two_machines
from ddh_twin_py.telemetry.recording import Recording, Stream
from ddh_twin_py.telemetry.signals import DRIVE_TOPIC, HYDRAULIC_TOPIC
from ddh_twin_py.twin.command import SLOWEST

MOTION = 10.0
"""s of turning drive that are needed to tell effects apart."""
HELD = 5.0
"""s of a field recording's end that are needed to size the gap, where there is no validation recording."""
PARTS = 20
"""Equal parts of a recording, in half of which what a free run cannot do without must be known."""
UNCOMMANDED = 0.15
"""Share of a recording in which it may be unknown where the rod was driven."""
_COPIED = 100
"""Different samples of one topic with the same stamps and values, from which two recordings overlap: no measurement repeats itself."""
_NO_FORCE = "there is neither pressure nor current, by which forces and losses would be known"
_FORCES = ("pressure_piston_side", "pressure_rod_side", "current")


def one_rig(recordings: Sequence[Recording]) -> None:
    """Refuse recordings of several rigs.

    Raises:
        ExperimentError: two recordings announce different rig_id, or one is of two machines at once.
    """
    for recording in recordings:
        if mixed := two_machines(recording):
            raise ExperimentError(mixed)
    named = [r for r in recordings if r.rig is not None and r.rig.rig_id]
    for other in named[1:]:
        if other.rig.rig_id != named[0].rig.rig_id:
            raise ExperimentError(f"{other.path}: {other.namespace}/rig: rig_id is {other.rig.rig_id!r}, but {named[0].path} is of rig "
                                  f"{named[0].rig.rig_id!r}; a case is of one rig")


def one_clock(recordings: Sequence[Recording]) -> None:
    """Refuse recordings whose drive and hydraulics are of clocks seconds or minutes apart.

    Raises:
        ExperimentError: no free run over such a recording goes where its rod goes.
    """
    for recording in recordings:
        if apart := other_clock(recording):
            raise ExperimentError(f"{apart}, and a free run needs one clock for both")


def no_twice(recordings: Sequence[Recording]) -> None:
    """Refuse recordings that are copies of one another or overlap, whatever their files are called.

    Raises:
        ExperimentError: two recordings share samples, with the same stamps and values.
    """
    for other, one in ((b, a) for i, b in enumerate(recordings) for a in recordings[:i]):
        for topic in () if _contradict(one, other) else (DRIVE_TOPIC, HYDRAULIC_TOPIC):
            if common := _in_common(one, other, topic):
                raise ExperimentError(f"{one.path} and {other.path} {common}; its samples would count twice")


def _contradict(one: Recording, other: Recording) -> bool:
    """Whether a temperature differs at most stamps that two recordings have in common, as of simulations of which heat alone differs."""
    for name, mine in one.temperatures.items():
        if name not in other.temperatures:
            continue
        theirs = other.temperatures[name]
        here, there = _at_once(one, mine, other, theirs)
        if here.size and np.mean(mine.values[here, 0] != theirs.values[there, 0]) > 0.5:
            return True
    return False


def _at_once(one: Recording, mine: Stream, other: Recording, theirs: Stream) -> tuple[np.ndarray, np.ndarray]:
    """Where in either of two recordings' streams the samples are whose stamps both have, (k,) each."""
    _, here, there = np.intersect1d(mine.stamps(one.epoch_ns), theirs.stamps(other.epoch_ns), return_indices=True)
    return here, there


def _in_common(one: Recording, other: Recording, topic: str) -> str:
    """What two recordings share of a topic, stamps and values, in words; '' where that is nothing, or hardly ever changes."""
    mine, theirs = (dict(recording.streams()).get(topic) for recording in (one, other))
    if mine is None or theirs is None:
        return ""
    here, there = _at_once(one, mine, other, theirs)
    a, b = mine.values[here], theirs.values[there]
    shared = here[np.all((a == b) | (np.isnan(a) & np.isnan(b)), axis=1)]
    if np.unique(np.nan_to_num(mine.values[shared]), axis=0).shape[0] < _COPIED:
        return ""
    if shared.size == len(mine) == len(theirs):
        return "are the same recording"
    return (f"overlap: {shared.size} samples of {one.namespace}/{topic}, from {mine.time[shared].min():.1f} s to "
            f"{mine.time[shared].max():.1f} s of the first, are in both")


def out_of_order(field: Sequence[Recording], commissioning: Recording | None) -> list[str]:
    """A note where the rig as built was recorded after what is asked about, none where the order is as it should be."""
    if commissioning is None or not field:
        return []
    first, built = min(field, key=_begin), _begin(commissioning)
    days = (built - _begin(first)) / 86400e9
    return [f"commissioning and field may be interchanged: {commissioning.path}, given as the rig as built, was recorded {days:.3g} days "
            f"after {first.path}; if they are, what is told here has gone since"] if days > 0.0 else []


def _begin(recording: Recording) -> int:
    """Of its samples, ns of the recording's clock."""
    return recording.epoch_ns + round(recording.span[0] * 1e9)


def undriven(recording: Recording) -> str:
    """What a free run over a recording lacks, in one line; empty where it lacks nothing."""
    for topic, stream, column, why in (
        (DRIVE_TOPIC, recording.drive, "speed_command", "is driven by it"),
        (HYDRAULIC_TOPIC, recording.hydraulic, "rod_position", "starts from it and is put back to it"),
    ):
        if not _known(stream, column):
            known = parts_known(stream, column)
            has = f"usable values in {known} of {PARTS} equal parts of the recording only" if known else "no usable value"
            return (f"{recording.path}: {recording.namespace}/{topic}: {column} has {has}, and the free run {why}"
                    + _because(recording, topic, column))
    between = float(np.median(np.diff(np.sort(recording.drive.time))))
    if between > SLOWEST:
        return (f"{recording.path}: {recording.namespace}/{DRIVE_TOPIC}: comes every {between:.2g} s, and the free run needs its command "
                f"at least every {SLOWEST:g} s")
    ambient = recording.temperatures.get("ambient")
    if ambient is None or not np.isfinite(ambient.values[:, 0]).any():
        return (f"{recording.path}: {recording.namespace}/temperature/ambient: there is no usable value, and the free run needs the "
                "ambient temperature" + _because(recording, "temperature/ambient", ""))
    return ""


def uncommanded(experiment: Experiment) -> str:
    """That a run does not know for too long where the rod was driven, in one line, else empty."""
    seconds, duration = experiment.left_out.get(COMMANDS_LOST, 0.0), experiment.duration
    if seconds <= UNCOMMANDED * duration:
        return ""
    recording = experiment.recording
    return (f"{recording.path}: {recording.namespace}/{DRIVE_TOPIC}: messages were lost while speed_command changed, and for "
            f"{seconds:.0f} s of {duration:.0f} s the free run does not know where the rod was driven, nor what heat that made")


def _known(stream: Stream | None, column: str) -> bool:
    """Whether a column has finite values in half of the `PARTS` of its stream."""
    return 2 * parts_known(stream, column) >= PARTS


def parts_known(stream: Stream | None, column: str) -> int:
    """In how many of `PARTS` equal parts of a stream's time there is a finite value, 0 where there is no stream."""
    if stream is None:
        return 0
    known = np.isfinite(stream.column(column))
    first, last = stream.time.min(initial=np.inf), stream.time.max(initial=-np.inf)
    if not known.any() or last <= first:
        return 0
    part = np.minimum(PARTS * (stream.time[known] - first) // (last - first), PARTS - 1)
    return np.unique(part).size


def _because(recording: Recording, topic: str, column: str) -> str:
    """What screening says of a column of a topic, errors first, in brackets; '' where it says nothing."""
    found = [f for f in recording.findings if f.topic == f"{recording.namespace}/{topic}" and f.field and column in f.field]
    found.sort(key=lambda f: f.severity != "error")
    return f" ({found[0].message.removeprefix(f'{recording.path}: ')})" if found else ""


def refuse_unfit(experiment: Experiment, role: str) -> None:
    """Refuse a commissioning or validation recording that says nothing.

    Raises:
        ExperimentError: no free run can be made over it, or the drive hardly turns in it.
    """
    if still := _still([experiment]):
        lacking = f"{experiment.recording.path}: {still}, at least {MOTION:.0f} s are needed"
    else:
        lacking = undriven(experiment.recording) or uncommanded(experiment) or _forceless(experiment)
    if lacking:
        raise ExperimentError(f"{lacking}; leave this {role} recording out")


def _forceless(experiment: Experiment) -> str:
    """That nothing tells of forces, else empty."""
    told = any(_tells(experiment, name) for name in _FORCES)
    return "" if told else f"{experiment.recording.path}: {_NO_FORCE}"


def turning(experiments: Sequence[Experiment]) -> float:
    """s in which the drive is told to turn, all recordings together."""
    return sum(float(np.count_nonzero(e.phase_of_intervals() != HOLDING)) * e.interval for e in experiments)


def _still(experiments: Sequence[Experiment]) -> str:
    """That the drive hardly turns, else empty; asked first, as a rod that never moves looks like a sensor that is stuck."""
    moving = turning(experiments)
    told = all(_known(e.recording.drive, "speed_command") for e in experiments)
    return f"the drive turns for {_at_most(moving)} s only" if told and moving < MOTION else ""


def _at_most(seconds: float) -> str:
    """Cut to tenths, so that too few never read as enough."""
    return f"{math.floor(10.0 * seconds) / 10.0:.1f}"


def no_answer(field: Sequence[Experiment], validated: bool) -> str:
    """Why the field recordings allow no answer, empty where they do.

    Args:
        validated: whether a validation recording sizes the gap.
    """
    if still := _still(field):
        return f"{still}; at least {MOTION:.0f} s of motion are needed to tell effects apart"
    for experiment in field:
        if lacking := undriven(experiment.recording) or uncommanded(experiment):
            return lacking
    if not any(_tells(e, name) for e in field for name in _FORCES):
        return _NO_FORCE
    longest = max(e.duration - e.held_from for e in field)
    if not validated and longest < HELD:
        return (f"the field recordings are too short to hold a part of them out: of {max(e.duration for e in field):.0f} s the last "
                f"{_at_most(longest)} s would count, {HELD:.0f} s are needed; give a validation recording or a longer field recording")
    if not validated and not any((np.isfinite(s.measured) & (s.time > e.held_from)).any() for e in field for s in e.signals.values()):
        return (f"the field recordings hold no usable sample in the part that would be held out (of {field[0].recording.path} from "
                f"{field[0].held_from:.0f} s on); a validation recording, or a whole field recording, is needed")
    return ""


def _tells(experiment: Experiment, name: str) -> bool:
    """Whether a force's signal is there for long enough to say something."""
    stream = experiment.recording.drive if name == "current" else experiment.recording.hydraulic
    return name in experiment.signals and _known(stream, name)


def unseen(effects: Sequence[Effect], columns: Sequence[Column]) -> list[str]:
    """Ids of effects that no signal would show at any size that is allowed."""
    seen = {column.effect.id for column in columns}
    return [effect.id for effect in effects if effect.id not in seen]
