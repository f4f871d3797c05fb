"""Times in messages, which count seconds and nanoseconds apart."""

from __future__ import annotations

from builtin_interfaces.msg import Time

_SECOND = 1_000_000_000  # ns


def set_time(time: Time, ns: int) -> None:
    """Set a time of a message, in place."""
    time.sec, time.nanosec = divmod(ns, _SECOND)


def ns_of(time: Time) -> int:
    """A time of a message, ns."""
    return time.sec * _SECOND + time.nanosec
