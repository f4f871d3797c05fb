"""Streams of the machine that come so seldom that most intervals of the twin have no sample."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording
from ddh_twin_py.telemetry.signals import MACHINE_FIELDS, RATES
from ddh_twin_py.telemetry.ticks import INTERVAL

_SLACK = 1.05  # times an interval between two samples, which still is one for each
_FEW = 10  # steps between samples that tell a rate


def too_seldom(recording: Recording) -> list[Finding]:
    """A warning for each such topic. Below the interface's lowest rate, but with a sample in each interval, nothing is said."""
    found = []
    for topic, stream in recording.streams():
        steps = np.diff(np.sort(stream.time))
        steps = steps[steps > 0.0]
        if topic not in MACHINE_FIELDS or steps.size < _FEW or (step := float(np.median(steps))) <= _SLACK * INTERVAL:
            continue
        name, (low, high) = f"{recording.namespace}/{topic}", RATES[topic]
        message = (f"{recording.path}: {name} comes at {1.0 / step:.1f} Hz; {low:g} to {high:g} Hz are needed: what happens between two "
                   "samples is lost")
        found.append(Finding("warning", recording.path, name, "", 1.0 / step, 1, message))
    return found
