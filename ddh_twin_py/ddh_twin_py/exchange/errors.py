"""What goes wrong with files of other tools."""

from __future__ import annotations


class ExchangeError(ValueError):
    """A file that cannot be taken over or made; one line that names file, line, column, value, what is allowed."""
