"""What the running test says of the gap, as the page tells it: the verdict in a sentence, signals with the largest first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ddh_twin_py.names import first_of
from ddh_twin_py.report.units import number, plain, shown, words
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

PLACES = {
    "speed": "motor", "current": "drive", "voltage": "drive", "electrical_power": "drive", "pressure_piston_side": "line_a",
    "pressure_rod_side": "line_b", "rod_velocity": "cylinder",
}  # fmt: skip
"""Where on the drawing a signal is measured; a temperature is where its sensor is."""


@dataclass(frozen=True)
class SignalNews:
    """How the test of one signal stands; as `ddh_msgs/SignalGap`, `since` in s."""

    signal: str
    unit: str
    tested: bool
    learned: float
    floor: float
    statistic: float
    threshold: float
    opened: bool
    since: float
    size: float
    deviation: float
    floors: float


def gap_document(component: str, because: str, signals: Sequence[SignalNews], stamp: float, hours: float) -> dict:
    """State (learning, none, open), verdict, component and why, rows of the signals.

    Args:
        stamp: data's time of the news, s. hours: mean time between false alarms of all signals, declared.
    """
    rows = sorted(signals, key=lambda s: (not s.opened, -abs(s.floors) if s.opened else -_share(s)))
    opened = [s for s in rows if s.opened]
    tested = sum(s.tested for s in rows)
    learned = max((s.learned for s in rows), default=0.0)
    if opened:
        state, verdict = "open", _open_sentence(opened, component, stamp)
    elif tested:
        state, verdict = "none", f"No gap: machine and twin agree in {tested} signals."
    else:
        state, verdict = "learning", f"Learning what is normal, {100.0 * learned:.0f} %; nothing is tested before."
    return {
        "state": state, "verdict": verdict, "component": component, "because": because, "hours": hours, "learned": learned,
        "stamp": stamp, "signals": [_row(s) for s in rows],
    }  # fmt: skip


def _open_sentence(opened: Sequence[SignalNews], component: str, stamp: float) -> str:
    names = [words(s.signal.removeprefix(TEMPERATURE_PREFIX)) for s in opened]
    listed = first_of(names, 3)
    minutes = max(0.0, stamp - min(s.since for s in opened)) / 60.0
    told = f"for {minutes:.0f} min of data" if minutes >= 1.0 else "just now"
    points = f" It points to: {words(component)}." if component else ""
    return f"A gap is open in {listed}, {told}; largest {abs(opened[0].floors):.1f} times the noise floor.{points}"


def _share(s: SignalNews) -> float:
    """Of the threshold that the statistic has reached, 0 where nothing is tested."""
    return s.statistic / s.threshold if s.tested and s.threshold > 0.0 and math.isfinite(s.statistic) else 0.0


def _row(s: SignalNews) -> dict:
    scale = shown(s.unit)
    place = s.signal.removeprefix(TEMPERATURE_PREFIX) if s.signal.startswith(TEMPERATURE_PREFIX) else PLACES.get(s.signal, "")
    size = ""
    if s.opened:
        size = f"{number(s.size * scale.factor, 2)} ± {plain(s.deviation * scale.factor, 1)} {scale.unit}"
    floor = f"{plain(s.floor * scale.factor, 2)} {scale.unit}" if math.isfinite(s.floor) else ""
    return {"signal": s.signal, "name": words(s.signal.removeprefix(TEMPERATURE_PREFIX)), "place": place, "tested": s.tested,
            "opened": s.opened, "share": _share(s), "learned": s.learned, "since": s.since if s.opened else None, "size": size,
            "floors": s.floors if s.opened else None, "floor": floor}  # fmt: skip
