"""Causes for which a sample or one of its fields is not believed, as bits of a flag."""

from __future__ import annotations

from enum import IntFlag


class Cause(IntFlag):
    """One bit per cause; a flag of 0 is a sound value.

    Of the field: NOT_A_NUMBER, INFINITE, OUT_OF_RANGE, WRONG_UNIT, STUCK, SATURATED (at or beyond the sensor's full scale); the value is
    not used.
    Of the whole sample: REPEATED (not used), OUT_OF_ORDER (sorted in), CLOCK_JUMP (first sample
    after the clock jumped back), GAP (first sample after the stream had stopped).
    """

    NOT_A_NUMBER = 1
    INFINITE = 2
    OUT_OF_RANGE = 4
    WRONG_UNIT = 8
    STUCK = 16
    REPEATED = 32
    OUT_OF_ORDER = 64
    CLOCK_JUMP = 128
    GAP = 256
    SATURATED = 512


REJECTING = Cause.NOT_A_NUMBER | Cause.INFINITE | Cause.OUT_OF_RANGE | Cause.WRONG_UNIT | Cause.STUCK | Cause.SATURATED
OF_FIELD = (Cause.NOT_A_NUMBER, Cause.INFINITE, Cause.OUT_OF_RANGE, Cause.WRONG_UNIT, Cause.STUCK, Cause.SATURATED)
OF_SAMPLE = (Cause.REPEATED, Cause.OUT_OF_ORDER, Cause.CLOCK_JUMP, Cause.GAP)
CAUSES = (*OF_FIELD, *OF_SAMPLE)
"""In the order of the rows in which screening counts them."""
