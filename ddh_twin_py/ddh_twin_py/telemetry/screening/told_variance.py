"""Variances that a temperature message tells and that no sensor has."""

from __future__ import annotations

import numpy as np

from ddh_twin_py.telemetry.recording import Finding, Recording
from ddh_twin_py.telemetry.signals import TEMPERATURE_PREFIX

_LARGEST = 1.0e4  # K2: of a sensor that is off by 100 K


def odd_variances(recording: Recording) -> list[Finding]:
    """A remark on each sensor that tells a variance below 0 or beyond `_LARGEST`; no calculation takes any, so nothing is lost by it."""
    found = []
    for name, stream in recording.temperatures.items():
        told = stream.column("variance")
        odd = np.flatnonzero((told < 0.0) | (told > _LARGEST))
        if not odd.size:
            continue
        topic, at, value = f"{recording.namespace}/{TEMPERATURE_PREFIX}{name}", float(stream.time[odd[0]]), float(told[odd[0]])
        found.append(Finding("info", recording.path, topic, "variance", value, int(odd.size), (
            f"{recording.path}: {topic} variance is {value:.4g} K2 at {at:.3f} s, allowed are 0 (not known) to {_LARGEST:g} K2; {odd.size} "
            f"of {len(stream)} are so. The readings are used with the noise of the rig file, as all are; does it mean invalid ones?"),
            at))
    return found
