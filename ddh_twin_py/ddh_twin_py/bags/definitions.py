"""Judge whether a message type in a bag is the one of the interface."""

from __future__ import annotations

import difflib
from functools import lru_cache

from rosbags.typesys import Stores, TypesysError, get_types_from_idl, get_types_from_msg, get_typestore

from ddh_twin_py.bags.message_types import telemetry_typestore
from ddh_twin_py.bags.storage import Channel
from ddh_twin_py.telemetry.signals import TOPIC_TYPES

_SEPARATOR = "=" * 80 + "\n"


def type_problem(channel: Channel, relative_topic: str) -> str:
    """What is wrong with the type of a known topic, as the end of a sentence; '' if nothing is."""
    expected = TOPIC_TYPES[relative_topic]
    if channel.message_type != expected:
        return f"has type {channel.message_type!r}, expected {expected!r}"
    if channel.serialization != "cdr":
        return f"is serialised as {channel.serialization!r}, expected 'cdr'"
    return definition_problem(channel.message_type, channel.definition, channel.definition_encoding, channel.type_hash)


@lru_cache(maxsize=64)
def definition_problem(message_type: str, text: str, encoding: str, type_hash: str) -> str:
    """How a recorded definition differs from the interface's, '' if it does not or none is there."""
    store = telemetry_typestore()
    expected = store.hash_rihs01(message_type)
    if text and encoding in ("ros2msg", "ros2idl"):
        try:
            recorded = _parse(message_type, text, encoding)
            found = recorded.hash_rihs01(message_type)
        except (TypesysError, KeyError, ValueError, IndexError) as error:
            return f"has a definition of {message_type!r} that cannot be parsed: {' '.join(str(error).split())}"
        if found != expected:
            return f"has another definition of {message_type!r}: {_difference(recorded, store, message_type)}"
    if type_hash and type_hash != expected:
        return f"has another definition of {message_type!r}: type hash {type_hash}, expected {expected}"
    return ""


def _parse(message_type: str, text: str, encoding: str):
    types = {}
    if encoding == "ros2msg":
        types.update(get_types_from_msg(text, message_type))
    else:
        for part in text.split(_SEPARATOR) if text.startswith(f"{_SEPARATOR}IDL: ") else [text]:
            body = part.split("\n", 1)[1] if part.startswith("IDL: ") else part
            if body.strip():
                types.update(get_types_from_idl(body))
    store = get_typestore(Stores.EMPTY)
    store.register(types)
    return store


def _difference(recorded, expected, message_type: str) -> str:
    """The first field that differs, or the nested type that does."""
    ours = [(name, str(kind)) for name, kind in expected.fielddefs[message_type][1]]
    theirs = [(name, str(kind)) for name, kind in recorded.fielddefs[message_type][1]]
    our_names, their_names = [n for n, _ in ours], [n for n, _ in theirs]
    missing = [name for name in our_names if name not in their_names]
    extra = [name for name in their_names if name not in our_names]
    if missing:
        near = difflib.get_close_matches(missing[0], extra, n=1, cutoff=0.3)
        return f"field {missing[0]!r} is missing" + (f", it has {near[0]!r}" if near else "")
    if extra:
        return f"unexpected field {extra[0]!r}"
    if our_names != their_names:
        return f"fields are in the order {', '.join(their_names)}, expected {', '.join(our_names)}"
    for (name, our_kind), (_, their_kind) in zip(ours, theirs, strict=True):
        if our_kind != their_kind:
            return f"field {name!r} is of another type"
    return "a nested type differs"
