"""Serialised messages as objects, where they are of the type that they should be."""

from __future__ import annotations

from rclpy.serialization import deserialize_message


def deserialised(message: bytes, message_type: type) -> object | None:
    """A serialised message as an object of its type; None where it is none, as one that is cut off."""
    try:
        return deserialize_message(message, message_type)
    except RuntimeError:
        return None
