"""Message classes by the name of their type."""

from __future__ import annotations

from importlib import import_module


def message_class(name: str) -> type | None:
    """Class of `sensor_msgs/msg/Temperature` and the like, None where its package is not there."""
    parts = name.split("/")
    if len(parts) != 3:
        return None
    try:
        return getattr(import_module(f"{parts[0]}.{parts[1]}"), parts[2], None)
    except ImportError:
        return None
