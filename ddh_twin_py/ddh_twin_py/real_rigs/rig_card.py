"""What is known of a rig's parameters, before or after a fit; stands where the direct driven unit has its rig file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Known:
    """A parameter: value and standard deviation in ``unit``, and where they come from."""

    value: float
    std: float
    unit: str
    source: str


@dataclass(frozen=True)
class RigCard:
    """A rig.

    Attributes:
        rig_id: name. file: where its description comes from. quantities: parameters by name.
    """

    rig_id: str
    file: str
    quantities: Mapping[str, Known]
