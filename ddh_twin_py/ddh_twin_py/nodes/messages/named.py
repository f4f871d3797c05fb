"""What messages name: values by the names that stand beside them, whole messages by their source."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_HEAD = 96  # bytes of a message in which its source is named


def ordered(names: Sequence[str], wanted: Sequence[str], values: np.ndarray, missing: float = np.nan) -> np.ndarray:
    """Columns (n, len(wanted)) of the wanted names out of ``values`` (n, len(names)), ``missing`` for one that is not there."""
    if list(names) == list(wanted):
        return values
    place = {name: i for i, name in enumerate(names)}
    found = np.full((len(values), len(wanted)), missing)
    for j, name in enumerate(wanted):
        if name in place:
            found[:, j] = values[:, place[name]]
    return found


def of_source(messages: Sequence[bytes], source: str) -> list[bytes]:
    """The messages, serialised, whose field `source` is this one."""
    named = source.encode() + b"\0"
    return [message for message in messages if named in message[:_HEAD]]
