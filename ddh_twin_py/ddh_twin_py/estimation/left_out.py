"""A replay without the sensors that it tells to be out of place."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np

from ddh_twin_py.estimation.doubts.out_of_place import FAR_OFF, LEAST, OutOfPlace, far, far_off_zero, few, look_exchanged, stand_still
from ddh_twin_py.estimation.doubts.still_watch import StillWatch
from ddh_twin_py.estimation.fusion.credibility import FARTHEST_OFFSET
from ddh_twin_py.estimation.fusion.inputs import Readings
from ddh_twin_py.estimation.replay_result import ReplayResult, SensorComparison
from ddh_twin_py.estimation.sensors import SENSORS

_AT_ONCE = 100  # intervals that are held against the free run at once


def out_of_place(result: ReplayResult) -> str:
    """Which sensors these are, and what that means for what is fused, in one line; '' where none is."""
    said = [found.left_out for found in result.left_out]
    if pair := _pair(result):
        said.append(f"{pair.why}; what is fused of both may be off by more than is stated")
    elif result.zero_error is not None and abs(result.zero_error[1]) > FAR_OFF:
        said.append(f"{far(result.zero_error)}; what is fused near it may be off by more than is stated")
    return "; ".join(said)


def without_those_out_of_place(run: Callable[[frozenset[str]], ReplayResult], without: Collection[str]) -> ReplayResult:
    """A replay without the sensors that it tells to be out of place.

    Two that look exchanged are left out at once. Those that stand still are where what is fused without them moves as the free run does,
    as on a unit that was told to move and did not. One that is far off its zero is where what is left then agrees: if more than `few` are,
    or another is in doubt yet, the unit is not what the twin takes it for, and all are used.

    Args:
        run: makes a replay without these sensors. without: sensors that are not used anyway.
    """
    unseen = frozenset(without)
    result = run(unseen)
    while (found := _pair(result)) is not None and not unseen.issuperset(found.sensors):
        unseen = unseen.union(found.sensors)
        result = replace(run(unseen), left_out=(*result.left_out, found))
    if still := _still(result):
        gone = unseen.union(*(found.sensors for found in still))
        tried = replace(run(gone), left_out=(*result.left_out, *still))
        if gone == unseen.union(*(found.sensors for found in _still(tried, fused=True))):
            result, unseen = tried, gone
    tried = result
    for _ in range(few(sum(sensor.used for sensor in result.sensors.values()))):
        found = far_off_zero(tried.zero_error, tried.rig) if tried.zero_error is not None else None
        if found is None or unseen.issuperset(found.sensors):
            break
        unseen = unseen.union(found.sensors)
        tried = replace(run(unseen), left_out=(*tried.left_out, found))
    return tried if tried.zero_error is not None and abs(tried.zero_error[1]) <= FARTHEST_OFFSET else result


def _pair(result: ReplayResult) -> OutOfPlace | None:
    """Two that look exchanged and are not left out yet."""
    gone = {sensor for found in result.left_out for sensor in found.sensors}
    off = np.full((len(SENSORS), len(SENSORS)), np.nan)
    for one, two in itertools.product([name for name in result.sensors if name not in gone], repeat=2):
        off[SENSORS.index(one), SENSORS.index(two)] = _off(result.sensors[one], result.sensors[two])
    return look_exchanged(off, result.rig)


def _still(result: ReplayResult, fused: bool = False) -> list[OutOfPlace]:
    """Those that do not move where the free run, or what is fused without them, says that they must."""
    read = {name: sensor for name, sensor in result.sensors.items() if sensor.used != fused}
    if not read:
        return []
    of = np.concatenate([np.full(sensor.row.size, SENSORS.index(name)) for name, sensor in read.items()])
    row, measured, shown = (np.concatenate([getattr(sensor, name) for sensor in read.values()])
                            for name in ("row", "measured", "fused" if fused else "predicted"))
    order = np.argsort(row, kind="stable")
    order = order[np.isfinite(measured[order])]
    watch, found = StillWatch(result.rig, LEAST), {}
    for part in np.split(order, np.searchsorted(row[order], np.arange(_AT_ONCE, len(result.time), _AT_ONCE))):
        watch.take(Readings(row[part], of[part], measured[part]), shown[part])
        found.update(watch.still)
    return stand_still(found, len(result.sensors))


def _off(read: SensorComparison, of: SensorComparison) -> float:
    """RMS, K, by which a reading is off what the free run shows at a place, NaN where too little tells."""
    order = np.argsort(of.time, kind="stable")
    if not read.time.size or not order.size:
        return np.nan
    off = read.measured - np.interp(read.time, of.time[order], of.predicted[order])
    off = off[np.isfinite(off)]
    return float(np.sqrt(np.mean(off**2))) if off.size >= LEAST else np.nan
