"""Numbers of files that people write: finite and with a unit, or an error that says where and what was found."""

from __future__ import annotations

import math
import re

PURE_NUMBER = "1"
"""Unit of what has none; an entry of such a quantity may leave its unit out."""
_EXPONENT = re.compile(r"[-+]?[0-9]*\.?[0-9]+[eE][-+]?[0-9]+")
_LONGEST = 40


def finite_number(where: str, value: object, error: type[ValueError]) -> float:
    """The value as a float.

    Args:
        where: file and entry, for the message. value: as YAML gave it. error: what to raise.

    Raises:
        error: for text, true or false, infinity, NaN and integers beyond a float.
    """
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, (int, float)) else float(value)
    except OverflowError:
        number = math.inf
    if math.isfinite(number):
        return number
    shown = repr(value)
    shown = shown if len(shown) <= _LONGEST else shown[: _LONGEST - 3] + "..."
    hint = "; YAML wants a point and a sign, as in 1.0e+9" if isinstance(value, str) and _EXPONENT.fullmatch(value) else ""
    raise error(f"{where}: value is {shown}, a finite number is needed{hint}")
