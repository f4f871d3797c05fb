"""Messages that come now and then as the documents of the live page."""

from __future__ import annotations

from collections.abc import Iterable

from ddh_msgs.msg import GapStatus, LimitPrediction, PlayerStatus, RigInfo
from ddh_twin_py.rig import Rig, is_payload
from ddh_twin_py.web.gap_news import SignalNews, gap_document
from ddh_twin_py.web.history import GRID, LEVELS
from ddh_twin_py.web.quantities import BAND, FIRST_CHARTS, quantities
from ddh_twin_py.web.streams import STREAMS

_LIMIT_FIELDS = (
    "location", "limit", "temperature", "standard_deviation", "temperature_at_horizon", "time_to_limit", "time_to_limit_16",
    "time_to_limit_84", "probability", "allowed_current", "allowed_speed", "reached_at_rest",
)  # fmt: skip
_WARNED_WITHIN = "warned within [s]"  # of the fusion's status `limits` in /diagnostics
_PLAYER_FIELDS = ("bag", "position", "duration", "rate", "speed", "waiting", "paused", "ended", "loop")


def page_document(namespace: str, rig: Rig) -> dict:
    """What the page has to know before the first number: streams, quantities, look back, what the drawing needs of the rig."""
    return {
        "namespace": namespace, "grid": GRID, "band": BAND, "first_charts": list(FIRST_CHARTS), "quantities": quantities(),
        "levels": [{"step": level.step, "seconds": GRID * level.rows * level.kept} for level in LEVELS],
        "streams": [{"name": stream.name, "fields": list(stream.fields)} for stream in STREAMS],
        "rig": {"rig_id": rig.rig_id, "stroke": rig["cylinder.stroke"], "relief": rig["relief_valve.opening_pressure"]},
    }  # fmt: skip


def rig_document(message: RigInfo) -> dict:
    """As announced; a payload that is none, which no node takes, is None."""
    payload = message.payload_mass if is_payload(message.payload_mass) else None
    return {"rig_id": message.rig_id, "oil_grade": message.oil_grade, "payload_mass": payload}


def limits_document(message: LimitPrediction, status: Iterable[tuple[str, str]]) -> dict:
    """Margins and times to the limits; ``status``: values of the status `limits`, which tell from where on a limit is near, s."""
    rows = [{name: getattr(limit, name) for name in _LIMIT_FIELDS} for limit in message.limits]
    return {
        "horizon": message.horizon, "duty_known": message.duty_known, "rms_current": message.rms_current,
        "mean_absolute_speed": message.mean_absolute_speed, "limits": rows,
        "warn_within": next((float(value) for key, value in status if key == _WARNED_WITHIN), None),
    }  # fmt: skip


def gap_status_document(message: GapStatus) -> dict:
    """The running verdict."""
    signals = [
        SignalNews(
            row.signal, row.unit, row.tested, row.learned, row.floor, row.statistic, row.threshold, row.opened, _seconds(row.since),
            row.size, row.size_standard_deviation, row.size_in_floors,
        )  # fmt: skip
        for row in message.signals
    ]
    hours = message.time_between_false_alarms / 3600.0
    return gap_document(message.component, message.because, signals, _seconds(message.header.stamp), hours)


def player_document(message: PlayerStatus) -> dict:
    """Where the replay is."""
    told = {name: getattr(message, name) for name in _PLAYER_FIELDS}
    return told | {"position": round(message.position, 2), "speed": round(message.speed, 2)}


def _seconds(stamp) -> float:
    return stamp.sec + stamp.nanosec * 1e-9
