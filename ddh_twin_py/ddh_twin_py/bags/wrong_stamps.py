"""Leave out of a bag what has wrong stamps, and say so: a few far from all others, and those of another clock than most topics'."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.bags.collector import Arrived
from ddh_twin_py.telemetry.clocks.other_clocks import other_clocks
from ddh_twin_py.telemetry.clocks.strays import strays
from ddh_twin_py.telemetry.recording import Finding


@dataclass(frozen=True)
class LeftOut:
    """Stamps of a topic that were left out, ns, int64 (n,), never none, and those that were kept; ``ahead``: by how many s the first is of
    another clock than the others, None where it is far from all of them."""

    topic: str
    stamps: np.ndarray
    kept: np.ndarray
    ahead: float | None = None

    def finding(self, file: str, namespace: str, epoch: int) -> Finding:
        """That in words; ``epoch``: of the recording, ns."""
        topic, first = f"{namespace}/{self.topic}", int(self.stamps[0])
        at = (first - epoch) * 1e-9
        of = f"{self.stamps.size} of {self.stamps.size + self.kept.size}" if self.kept.size else f"all {self.stamps.size}"
        count = f"{file}: {of} messages on {topic}"
        if self.ahead is not None:
            where = "ahead of" if self.ahead > 0.0 else "behind"
            at = max(0.0, at - self.ahead)
            message = (f"{count} are of another clock than most topics, as the recorder's clock tells, and are left out: the first, at "
                       f"{at:.1f} s of the recording, is stamped {abs(self.ahead):.1f} s {where} the others")
            return Finding("warning", file, topic, "header.stamp", self.ahead, int(self.stamps.size), message, at, mended=True)
        after = self.stamps > self.kept[0]
        where = "after" if after.all() else "before or after" if after.any() else "before"
        message = (f"{count} have a stamp far {where} all others and are left out, the first {first * 1e-9:.3f} s, which is {at:+.1f} s of "
                   "the recording")
        return Finding("warning", file, topic, "header.stamp", first * 1e-9, int(self.stamps.size), message, at, mended=True)


def sound(rows: Mapping[str, Arrived]) -> tuple[dict[str, Arrived], list[LeftOut]]:
    """The rows without those whose stamps are wrong, by topic, and what was left out; a topic of which nothing remains is none of them."""
    near, far = _without(rows, {topic: (here, None) for topic, here in strays({topic: part.stamp for topic, part in rows.items()}).items()})
    clocks = other_clocks({topic: part.stamp for topic, part in near.items()}, {topic: part.log_time for topic, part in near.items()})
    same, other = _without(near, {topic: (here, ahead * 1e-9) for topic, (here, ahead) in clocks.items()})
    return {topic: part for topic, part in same.items() if part.stamp.size}, far + other


def _without(rows: Mapping[str, Arrived], wrong: Mapping[str, tuple[np.ndarray, float | None]]) -> tuple[dict[str, Arrived], list[LeftOut]]:
    """The rows without those that are wrong, bool (n,) by topic, and these."""
    kept, left_out = dict(rows), []
    for topic, (here, ahead) in wrong.items():
        if here.any():
            kept[topic] = rows[topic].at(~here)
            left_out.append(LeftOut(topic, rows[topic].stamp[here], kept[topic].stamp, ahead))
    return kept, left_out
