"""What is known of a payload where each recording and duty declares its own: how many times as much the rod lifts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ddh_twin_py.rig.sheet import Quantity

PAYLOAD, RATIO = "load.payload_mass", "load.payload_ratio"


def of_declared_payload(quantities: Mapping[str, Quantity], before: Mapping[str, Quantity]) -> dict[str, Quantity]:
    """Quantities of which a fit or an effect changed the payload, with that change as the ratio to what is declared.

    A payload written as such would be lost on every recording that declares one. The rig goes on to declare what it did, as uncertain,
    by share, as it is now.

    Args:
        quantities: after, by dotted path. before: of the rig that was fitted.
    """
    payload, declared = quantities[PAYLOAD], before[PAYLOAD]
    more = payload.value / declared.value
    if more == 1.0:
        return dict(quantities)
    ratio = replace(quantities[RATIO], value=more * before[RATIO].value, source=payload.source)
    std = None if payload.std is None else payload.std / more
    return {**quantities, RATIO: ratio, PAYLOAD: replace(declared, std=std)}
