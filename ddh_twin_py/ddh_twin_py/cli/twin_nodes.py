"""The nodes that a twin is made of, for whoever starts them."""

from __future__ import annotations

from pathlib import Path

MODELS = ("hydraulic_model", "machine_thermal", "temperature_fusion")
TWIN = (*MODELS, "gap_monitor")
"""Nodes that always run."""
FLUSH_AFTER = 1.0
"""s without a message after which models work off what they hold: a bag that has ended, or was paused, gives nothing more."""


def played_topics(bag: str | Path) -> list[str]:
    """Which topics of a bag a player plays to the twin: telemetry and rig, as the twin's own outputs in it would be told twice; all, where
    its metadata.yaml lists none of those.

    Raises:
        BagError: there is no bag.
    """
    from ddh_twin_py.bags.folder import open_folder
    from ddh_twin_py.bags.topics import split_topic
    from ddh_twin_py.telemetry.signals import TOPIC_TYPES

    listed = open_folder(bag).topics
    return ["*"] if listed is not None and not any(map(split_topic, listed)) else list(TOPIC_TYPES)
