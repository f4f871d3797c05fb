"""A node parameter's value as YAML, as `-p name:=value` wants it."""

from __future__ import annotations


def parameter_yaml(value: object) -> str:
    """The value as one line of YAML; text is always quoted, so that `1` or `true` stay text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(parameter_yaml(entry) for entry in value) + "]"
    if isinstance(value, (int, float)):
        return repr(value)
    return "'" + str(value).replace("'", "''") + "'"
