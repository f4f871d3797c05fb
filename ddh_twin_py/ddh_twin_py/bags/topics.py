"""Tell the rig's topics from the others, and one rig's namespace from another's."""

from __future__ import annotations

import difflib

from ddh_twin_py.bags.errors import BagError
from ddh_twin_py.names import first_of
from ddh_twin_py.telemetry.signals import (
    DRIVE_TOPIC,
    HYDRAULIC_TOPIC,
    RIG_TOPIC,
    TEMPERATURE_PREFIX,
    TEMPERATURE_SENSORS,
    TOPIC_TYPES,
)

_MOST_NAMED = 6  # topics of a bag that has no telemetry


def split_topic(topic: str) -> tuple[str, str] | None:
    """Namespace and relative name of a telemetry topic, None for any other.

    `/plant/ddh/drive/telemetry` is `/plant/ddh` and `drive/telemetry`; the root namespace is ''.
    """
    for relative in TOPIC_TYPES:
        if topic.endswith("/" + relative):
            return topic[: -len(relative) - 1], relative
    return None


def normalised(namespace: str) -> str:
    """A namespace with one leading slash and no trailing one; the root is ''."""
    stripped = namespace.strip("/")
    return f"/{stripped}" if stripped else ""


def choose_namespace(path: str, types: dict[str, str], wanted: str | None, by: str = "--namespace NAME") -> str:
    """The namespace of the rig among the topics (name to type) of a bag; `by` what a person chooses one.

    Raises BagError when there is none, the wanted one is absent, or two rigs are there and
    none is wanted.
    """
    namespaces: dict[str, set[str]] = {}
    for topic, message_type in types.items():
        split = split_topic(topic)
        if split and (message_type == TOPIC_TYPES[split[1]] or split[1] in (DRIVE_TOPIC, HYDRAULIC_TOPIC)):
            namespaces.setdefault(split[0], set()).add(split[1])
    machines = [n for n, names in namespaces.items() if names & {DRIVE_TOPIC, HYDRAULIC_TOPIC}]
    candidates = sorted(machines or namespaces)
    if wanted is not None:
        wanted = normalised(wanted)
        if wanted in namespaces:
            return wanted
        there = ", ".join(repr(n or "/") for n in candidates) or "none"
        raise BagError(f"{path} has no telemetry in namespace {wanted or '/'!r}; namespaces with telemetry: {there}")
    if not candidates:
        raise BagError(f"{path} has no telemetry: expected topics such as /ddh/{DRIVE_TOPIC}; it has {_listed(types)}")
    if len(candidates) > 1:
        names = " and ".join(repr(n or "/") for n in candidates)
        raise BagError(f"{path} holds {len(candidates)} rigs, in the namespaces {names}; choose one with {by}")
    return candidates[0]


def nearest_telemetry(topic: str, namespace: str) -> str:
    """Telemetry topic that an unknown topic of the namespace was probably meant to be, or ''."""
    if not topic.startswith(namespace + "/"):
        return ""
    relative = topic[len(namespace) + 1 :]
    if relative.startswith(TEMPERATURE_PREFIX):
        sensor = relative[len(TEMPERATURE_PREFIX) :]
        return TEMPERATURE_PREFIX + difflib.get_close_matches(sensor, TEMPERATURE_SENSORS, n=1, cutoff=0.0)[0]
    names = [name for name in TOPIC_TYPES if name != RIG_TOPIC]
    return next(iter(difflib.get_close_matches(relative, names, n=1, cutoff=0.8)), "")


def _listed(types: dict[str, str]) -> str:
    return first_of(sorted(types), _MOST_NAMED) or "no topics"
