"""A linearisation of three effects and three signals, one row each, and a hypothesis fitted to it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
from ddh_twin_py.gap.evidence.sensitivity import Column
from ddh_twin_py.gap.explain.refit import Refitted

from support.first_order import EFFECTS

SIGNALS = ("pressure", "current", "housing")
COLUMNS = [Column(replace(effect, law_error=0.1), 0, 0.1, 5.0, signal, []) for effect, signal in zip(EFFECTS, SIGNALS, strict=True)]


def linearised(likeness, told=((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))):
    """Of three effects; ``told``: information in each of three signals about the first two."""
    information = np.array([[100.0, likeness * 100.0, 0.0], [likeness * 100.0, 100.0, 0.0], [0.0, 0.0, 100.0]])
    rows = np.sqrt(np.column_stack([np.array(told, float), np.zeros(3)]))
    blocks = [SimpleNamespace(signal=signal, rows=slice(i, i + 1)) for i, signal in enumerate(SIGNALS)]
    columns = [replace(column, change=[own]) for column, own in zip(COLUMNS, rows.T, strict=True)]
    return SimpleNamespace(columns=columns, evidence=SimpleNamespace(sums=SimpleNamespace(information=information)),
                           comparisons=[SimpleNamespace(blocks=blocks, size=len(blocks))],
                           basis=SimpleNamespace(beyond=lambda columns: [c**2 for c in columns]))


def fitted(*departures):
    x = 0.1 * np.array(departures)
    return Refitted(tuple(COLUMNS[: x.size]), x, np.eye(x.size), np.eye(x.size), np.zeros(0), [], 0.0, 0.0, np.zeros(x.size))
