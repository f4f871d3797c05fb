"""What is odd about the stamps of a bag and may be right: a pace that is not the recorder's, a time since a machine was switched on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ddh_twin_py.bags.collector import Arrived
from ddh_twin_py.names import first_of
from ddh_twin_py.telemetry.recording import Finding

_SINCE_BOOT = 10 * 365 * 86400  # s: no stamp of a clock that was ever set is older
_PACE, _ALIKE = 1.2, 1.1  # times as fast as the recorder's clock, either way, from which it is told; so far apart are equal paces
_PARTS, _LEAST, _SHORTEST = 20, 100, 1.0  # parts of a topic that are looked at, messages of it, and s by the slower clock, that tell a pace
_NAMED = 3  # topics that are named one by one


def odd_stamps(rows: Mapping[str, Arrived], file: str, namespace: str, epoch: int) -> list[Finding]:
    """Remarks on stamps that are used as they are.

    Args:
        rows: by relative topic. epoch: of the recording, ns.
    """
    return [*_since_boot(rows, file, epoch), *_paces(rows, file, namespace)]


def _since_boot(rows: Mapping[str, Arrived], file: str, epoch: int) -> list[Finding]:
    seconds = epoch * 1e-9
    if seconds > _SINCE_BOOT or not any(part.stamp.any() for part in rows.values()):
        return []
    message = (f"{file}: header.stamp begins at {seconds:.3f} s, which is in 1970: likely seconds since the machine, or a simulation, was "
               "started, as its clock was never set; used as they are, dates mean nothing")
    return [Finding("info", file, "", "header.stamp", seconds, sum(part.stamp.size for part in rows.values()), message, 0.0)]


def _paces(rows: Mapping[str, Arrived], file: str, namespace: str) -> list[Finding]:
    """One remark on all topics of one pace."""
    paces = {topic: pace for topic, part in rows.items() if (pace := _pace(part)) is not None}
    odd = {topic: pace for topic, pace in paces.items() if not 1.0 / _PACE < pace < _PACE}
    found = []
    while odd:
        pace = next(iter(odd.values()))
        same = [topic for topic, other in odd.items() if 1.0 / _ALIKE < other / pace < _ALIKE]
        named = first_of([f"{namespace}/{topic}" for topic in same], _NAMED)
        whose = f"all topics in {namespace or '/'}" if len(same) == len(paces) > 1 else named
        stamped, took = max(tuple(float(np.ptp(clock)) * 1e-9 for clock in (rows[topic].stamp, rows[topic].log_time)) for topic in same)
        message = (f"{file}: header.stamp of {whose} goes on {pace:.3g} times as fast as the recorder's clock: {stamped:.4g} s by the "
                   f"stamps, {took:.4g} s by the recorder; so it is where a replay was recorded, elsewhere the stamps are in another "
                   "unit. They are used as they are")
        where = f"{namespace}/{same[0]}"
        found.append(Finding("info", file, where, "header.stamp", pace, sum(rows[topic].stamp.size for topic in same), message, 0.0))
        odd = {topic: other for topic, other in odd.items() if topic not in same}
    return found


def _pace(part: Arrived) -> float | None:
    """How many times as fast as the recorder's clock the stamps of a topic go on; None where that is not steady or nothing tells it."""
    if part.stamp.size < _LEAST:
        return None
    edges = np.linspace(0, part.stamp.size - 1, _PARTS + 1).astype(np.int64)
    stamped, took = (np.diff(clock[edges]) * 1e-9 for clock in (part.stamp, part.log_time))
    if min(stamped.min(), took.min()) <= 0.0 or max(stamped.sum(), took.sum()) < _SHORTEST:
        return None
    low, pace, high = np.quantile(stamped / took, [0.25, 0.5, 0.75])
    return float(pace) if high < _ALIKE * low else None
