"""Free runs of one fit side by side: fits that last longest would else leave a core idle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

THREADS = 2
"""Free runs side by side; a diagnosis is made for two cores."""
T = TypeVar("T")
_runs = ThreadPoolExecutor(max_workers=THREADS, thread_name_prefix="free run")


def side_by_side(calls: Sequence[Callable[[], T]]) -> list[T]:
    """What each of some calls returns, in their order; a call must not come here itself.

    Raises:
        whatever the first that fails raises.
    """
    return [waited.result() for waited in [_runs.submit(call) for call in calls]]
