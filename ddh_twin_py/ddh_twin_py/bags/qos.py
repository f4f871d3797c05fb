"""Quality of service as bags record it."""

from __future__ import annotations

from collections.abc import Sequence

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from ddh_twin_py.names import no_such

_INFINITE = QosTime(9223372036, 854775807)

_RELIABILITIES = {
    "reliable": QosReliability.RELIABLE,
    "best_effort": QosReliability.BEST_EFFORT,
    "system_default": QosReliability.SYSTEM_DEFAULT,
}
_DURABILITIES = {
    "volatile": QosDurability.VOLATILE,
    "transient_local": QosDurability.TRANSIENT_LOCAL,
    "system_default": QosDurability.SYSTEM_DEFAULT,
}


def qos_profile(reliability: str = "reliable", durability: str = "volatile", depth: int = 10) -> list[Qos]:
    """A recorded profile: reliable, best_effort or system_default; volatile, transient_local or
    system_default; keep last `depth`. Raises ValueError naming the valid choices."""
    return [
        Qos(
            QosHistory.KEEP_LAST,
            depth,
            _chosen("reliability", reliability, _RELIABILITIES),
            _chosen("durability", durability, _DURABILITIES),
            _INFINITE,
            _INFINITE,
            QosLiveliness.AUTOMATIC,
            _INFINITE,
            False,
        )
    ]


def _chosen(what: str, given: str, valid: dict):
    try:
        return valid[given]
    except KeyError:
        raise ValueError(no_such(what, given, valid)) from None


SENSOR_DATA: Sequence[Qos] = qos_profile("best_effort", depth=5)
"""What `drive/telemetry`, `hydraulics/telemetry` and `temperature/*` are published with."""

LATCHED: Sequence[Qos] = qos_profile(durability="transient_local", depth=1)
"""What `rig` is published with."""

RELIABLE: Sequence[Qos] = qos_profile()
"""The default of ROS 2."""
