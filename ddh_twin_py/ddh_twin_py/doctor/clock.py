"""Does this computer's clock tell the time: stamps of several computers must fit together within a fraction of a second."""

from __future__ import annotations

import ctypes
import time

from ddh_twin_py.doctor.check import Check

GROUP = "clock"
_BEGIN_OF_PROJECT = 1_735_689_600  # s, 2025-01-01 UTC
_UNSYNCHRONISED = 5  # TIME_ERROR of adjtimex(2)
_TIMEX_BYTES = 512  # more than struct timex takes


def check_clock() -> list[Check]:
    """Date, and whether something keeps the clock in step."""
    now = time.time()
    date = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(now))
    if now < _BEGIN_OF_PROJECT:
        return [Check(GROUP, "date", "error", date, "after 2025-01-01", "set the clock: a computer without battery forgets it")]
    return [Check(GROUP, "date", "ok", date, "after 2025-01-01"), _synchronised(_state())]


def _state() -> int | None:
    """What the kernel says of its clock (adjtimex(2)), None where it cannot be asked."""
    try:
        return ctypes.CDLL(None, use_errno=True).adjtimex(ctypes.create_string_buffer(_TIMEX_BYTES))
    except (OSError, AttributeError):
        return None


def _synchronised(state: int | None) -> Check:
    right = "kept in step (NTP, PTP)"
    if state is None or state < 0:
        return Check(GROUP, "synchronisation", "note", "the kernel does not say", right, "see timedatectl or chronyc tracking")
    if state == _UNSYNCHRONISED:
        return Check(GROUP, "synchronisation", "note", "nothing keeps this clock in step", right,
                     "where machine and twin run on two computers: install chrony on both, or PTP")
    return Check(GROUP, "synchronisation", "ok", "in step", right)
