"""What no free run predicts to the sample, so that it is not compared: sticking and slipping, sinking onto a stop, commands that were lost.

A rod that sticks and slips at low speed swings by its own velocity, at a phase that nothing tells. A load that sinks onto an end stop
while it rests meets it some seconds earlier or later, by a leakage within its tolerance, and its pressure is gone from then on.
Where messages of the drive are lost while the command changes, a run moves the rod at another time and to another place.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.telemetry.in_order import in_order
from ddh_twin_py.twin.command import command_at
from ddh_twin_py.twin.course import CARRIED

SUNK, COMMANDS_LOST = "a resting load sinks onto an end stop", "commands of the drive were lost"
"""Reasons for which fast signals are not compared."""
SLIPS = "the rod sticks and slips"
"""Reason for which its velocity is not."""
_WINDOW = 0.8  # s
_AFTER_A_STEP = 0.2  # s
_SLOW, _OFTEN = 0.3, 0.15  # of the mean velocity, below which a rod sticks; share of either half of a window in which it does
_STRETCH = 0.2  # share of a stretch in which it must be found
_TOLD = 2.5  # noises of a velocity that tells
_STILL = 1e-9  # rad/s of the command, and of its changes
_LOST, _CHANGED = 0.25, 1.0  # s without a command; rad/s by which it is another then
_SETTLED = 0.5  # s after the rod is moved on, in which the oil forgets
_AT_STOP, _SUNK, _UNSURE = 1.0e-3, 2.0e-3, 0.2  # m from a stop; m on the way to it that count; share of that way by which a run may differ


@dataclass(frozen=True)
class Unpredictable:
    """Where a recording's fast signals are not compared.

    Attributes:
        sunk, lost: intervals, bool (n,); see `sunk_onto_a_stop`, `command_lost`. slips: samples of the hydraulics, bool (m,); see
            `sticks_and_slips`. interval: s.
    """

    sunk: np.ndarray
    lost: np.ndarray
    slips: np.ndarray
    interval: float

    @property
    def intervals(self) -> np.ndarray:
        """Intervals in which no fast signal is compared, bool (n,)."""
        return self.sunk | self.lost

    @property
    def seconds(self) -> Mapping[str, float]:
        """How long it is so, s, by reason."""
        slips = float(np.count_nonzero(self.slips)) / max(1, self.slips.size) * self.sunk.size
        return {SUNK: self.sunk.sum() * self.interval, COMMANDS_LOST: self.lost.sum() * self.interval, SLIPS: slips * self.interval}


def unpredictable(position: np.ndarray, standing: np.ndarray, placed: np.ndarray, stroke: float, interval: float,
                  drive: tuple[np.ndarray, np.ndarray], hydraulic: tuple[np.ndarray, np.ndarray], noise: float,
                  set_ahead: Sequence[float] = ()) -> Unpredictable:
    """Where no free run predicts a recording to the sample.

    Args:
        position, placed: m, of intervals, (n,); see `command_lost`. standing: whether the command is zero throughout, (n,).
        stroke: m. interval: s. drive: times, s, and speed commands, rad/s, as they came, (k,) each. hydraulic: times, s, and velocities
            of the rod, m/s, as they came, (m,) each. noise: of a velocity, m/s. set_ahead: see `command_lost`.
    """
    sunk = sunk_onto_a_stop(position, standing, stroke)
    lost = command_lost(*drive, position, placed, interval, set_ahead)
    time, velocity = hydraulic
    order = np.argsort(time, kind="stable")
    hidden = (sunk | lost)[intervals_at(time, interval, sunk.size)]
    slips = np.zeros(velocity.size, bool)
    slips[order] = sticks_and_slips(time[order], np.where(hidden, np.nan, velocity)[order], command_at(*drive, time[order]), noise)
    return Unpredictable(sunk, lost, slips, interval)


def intervals_at(time: np.ndarray, interval: float, count: int) -> np.ndarray:
    """The interval of ``count`` in which each time, s (m,), lies, (m,); the nearest one of a time outside."""
    return np.clip((time / interval).astype(np.int64), 0, count - 1)


def sticks_and_slips(time: np.ndarray, velocity: np.ndarray, command: np.ndarray, noise: float) -> np.ndarray:
    """Whether a sample lies in a stretch of steady command in which the rod sticks and slips, bool (n,).

    Args:
        time: s, not falling, (n,). velocity: m/s, NaN where it is not known, (n,). command: of the speed at these times, rad/s, (n,).
        noise: of a velocity, m/s.
    """
    found = np.zeros(time.size, bool)
    if time.size < 2:
        return found
    changes = np.abs(np.diff(command, prepend=command[0])) > _STILL
    last = np.maximum.accumulate(np.where(changes, time, time[0] - _AFTER_A_STEP))
    steady = (time - last >= _AFTER_A_STEP) & (np.abs(command) > _STILL) & np.isfinite(velocity)
    window = (time / (0.5 * _WINDOW)).astype(np.int64)
    halves, index = np.unique(window[steady], return_inverse=True)
    if not halves.size:
        return found
    count = np.bincount(index)
    mean = np.bincount(index, velocity[steady]) / count
    stuck = np.bincount(index, velocity[steady] * np.sign(mean[index]) < _SLOW * np.abs(mean[index])) / count
    odd = (stuck > _OFTEN) & (np.abs(mean) > _TOLD * noise)
    beside = np.diff(halves, prepend=halves[0]) == 1
    twice = odd & beside & np.concatenate([[False], odd[:-1]])
    twice |= np.concatenate([twice[1:], [False]])
    stretch = np.cumsum(changes)[steady]
    _, within = np.unique(stretch, return_inverse=True)
    found[steady] = (np.bincount(within, twice[index]) > _STRETCH * np.bincount(within))[within]
    return found


def sunk_onto_a_stop(position: np.ndarray, standing: np.ndarray, stroke: float) -> np.ndarray:
    """Whether an interval lies where a resting rod has sunk, or may have sunk, onto an end stop, bool (n,); until it is moved again.

    Args:
        position: m, NaN where it is not known, (n,). standing: whether the command is zero throughout, (n,). stroke: m.
    """
    begins = standing & ~np.concatenate([[False], standing[:-1]])
    begun, stretch = np.maximum.accumulate(np.where(begins, np.arange(position.size), 0)), np.cumsum(begins)
    known = _last_known(position)
    sunk = known - known[begun]
    left = np.where(sunk < 0.0, known, stroke - known)
    near = standing & (np.abs(sunk) > _SUNK) & (left < _AT_STOP + _UNSURE * np.abs(sunk))
    met = standing & (np.abs(sunk) > _SUNK) & (left < _AT_STOP)
    meets = np.isin(stretch, np.unique(stretch[met])) & standing
    since = np.maximum.accumulate(np.where(near & meets, stretch, 0))
    return meets & (since == stretch)


def _last_known(values: np.ndarray) -> np.ndarray:
    """Each value, or the last one before it that is known; the first known one before that."""
    known = np.flatnonzero(np.isfinite(values))
    if not known.size:
        return np.zeros(values.size)
    return values[known[np.maximum(np.searchsorted(known, np.arange(values.size), "right") - 1, 0)]]


def command_lost(time: np.ndarray, command: np.ndarray, position: np.ndarray, placed: np.ndarray, interval: float,
                 set_ahead: Sequence[float] = ()) -> np.ndarray:
    """Whether an interval lies where a run does not know what was commanded, or where the rod was left by it, bool (n,).

    That lasts from the last message before a gap, in which the command changes, the rod is carried elsewhere, or the clock was set ahead
    so that it was not carried at all, until the rod is moved on from where it was placed anew: until then the oil holds the pressures of
    another move.

    Args:
        time, command: s, and rad/s, NaN where it is not known, (m,). position: m, measured, NaN where it is not known, (n,).
        placed: m, where the run's rod is placed, NaN elsewhere, (n,). interval: s. set_ahead: s, the midst of each hole that this makes.
    """
    lost = np.zeros(position.size, bool)
    known = in_order(time, command)
    if known.size < 2:
        return lost
    where, anew = _last_known(position), np.isfinite(placed)
    gaps = np.flatnonzero(np.diff(time[known]) > _LOST)
    for before, after in zip(known[gaps], known[gaps + 1], strict=True):
        first, last = intervals_at(time[[before, after]], interval, position.size).tolist()
        still = abs(command[before]) <= _CHANGED and abs(command[after]) <= _CHANGED
        stood = any(time[before] < at < time[after] for at in set_ahead)
        if stood or abs(command[after] - command[before]) > _CHANGED or (still and abs(where[last] - where[first]) > CARRIED):
            moved = np.flatnonzero(anew[last + 1 : -1] & ~anew[last + 2 :])
            lost[first : last + 2 + int(moved[0]) + round(_SETTLED / interval) if moved.size else position.size] = True
    return lost
