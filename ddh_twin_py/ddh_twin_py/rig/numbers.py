"""Numbers of files that people write: finite and with a unit, or an error that says where and what was found."""

from __future__ import annotations

import math
import re

from ddh_twin_py.names import cited

PURE_NUMBER = "1"
"""Unit of what has none; an entry of such a quantity may leave its unit out."""
_EXPONENT = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)[eE][-+]?[0-9]+")
"""What people write for a number and YAML 1.1 reads as text, as it wants a point and a sign (1.0e+9): 1.3e7, 1e9."""
_LONGEST = 40


def finite_number(where: str, value: object, error: type[ValueError]) -> float:
    """The value as a float.

    Args:
        where: file and entry, for the message. value: as YAML gave it. error: what to raise.

    Raises:
        error: where there is none, for text other than a number with an exponent, true or false, infinity, NaN and integers beyond a float.
    """
    try:
        written = isinstance(value, str) and len(value) <= _LONGEST and _EXPONENT.fullmatch(value)
        number = float(value) if written or isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan
    except OverflowError:
        number = math.inf
    if math.isfinite(number):
        return number
    if value is None:
        raise error(f"{where}: value is missing, a finite number is needed")
    raise error(f"{where}: value is {cited(value, _LONGEST)}, a finite number is needed")
