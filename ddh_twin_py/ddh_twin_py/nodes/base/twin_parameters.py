"""Parameters that several nodes of the twin have."""

from __future__ import annotations

from ddh_twin_py.nodes.base.parameters import Parameter
from ddh_twin_py.telemetry.ticks import INTERVAL, REORDER_WINDOW

RIG = Parameter("rig", "", "Rig sheet (YAML); entries left out are those of the reference sheet. Empty: the reference sheet.")
STALE_AFTER = Parameter("stale_after", 2.0, "Wall time without a message after which an input is called stale.", "s", 0.1, 3600.0)
TWIN_PARAMETERS = (
    RIG,
    Parameter("interval", INTERVAL, "Length of one interval of data; outputs come once for each.", "s", 0.01, 1.0),
    Parameter(
        "reorder_window", REORDER_WINDOW,
        "How late a message may be and is still sorted in; outputs lag behind the data by this. "
        "Streams that go on further back have a clock that jumped.", "s", 0.05, 10.0,
    ),
    STALE_AFTER,
    Parameter(
        "flush_after", 2.0,
        "Wall time without any message after which the last intervals are worked off without waiting for more.",
        "s", 0.2, 60.0,
    ),
)  # fmt: skip


def rig_path(given: str) -> str | None:
    """A path, or None for the reference sheet."""
    return given or None
