"""Whether kernels are being compiled: done once per version of the model, it takes longer than most work and tells no share."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

COMPILING = "compiling a part of the model, once per version"


@contextmanager
def watched(changed: Callable[[], None] = lambda: None) -> Iterator[Callable[[], bool]]:
    """Yields what says whether a kernel is compiled now; `changed` is called as that changes. Nothing is seen before numba is loaded."""
    if "numba" not in sys.modules:
        yield lambda: False
        return
    from numba.core import event

    depth = 0

    class Listener(event.Listener):
        def on_start(self, event) -> None:
            nonlocal depth
            depth += 1
            if depth == 1:
                changed()

        def on_end(self, event) -> None:
            nonlocal depth
            depth -= 1
            if depth == 0:
                changed()

    with event.install_listener("numba:compile", Listener()):
        yield lambda: depth > 0
