"""Readings of a rig that err."""

from dataclasses import replace


def misread(model, name, error):
    """Let one reading of the second recording err by a function of the share of its time that is over."""
    signal = model.signals[1][name]
    model.signals[1] = {**model.signals[1], name: replace(signal, measured=signal.measured + error(signal.time / signal.time[-1]))}
