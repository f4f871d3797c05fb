"""How far the live graph and the replay in one process are apart, as numbers and in a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.report.units import shown
from ddh_twin_py.twin.hydraulic_model import RESIDUAL_SIGNALS

if TYPE_CHECKING:
    from ddh_twin_py.estimation.replay_result import ReplayResult


@dataclass(frozen=True)
class Difference:
    """How far the live graph and the replay in one process are apart.

    `largest` of `name`, in `unit`; `in_noise` where the quantity has a noise (None: it has not).
    """

    name: str
    largest: float
    rms: float
    unit: str
    in_noise: float | None


def differences(live: ReplayResult, offline: ReplayResult) -> list[Difference]:
    """Live against in-process, over the intervals that came."""
    rig, found = live.rig, []

    def add(name: str, a: np.ndarray, b: np.ndarray, unit: str, noise: float | None) -> None:
        apart = np.abs(a - b)
        apart = apart[np.isfinite(apart)]
        if apart.size:
            largest, rms = float(apart.max()), float(np.sqrt(np.mean(apart**2)))
            found.append(Difference(name, largest, rms, unit, largest / noise if noise else None))

    noise = rig.sensors["temperature"].noise
    add("fused temperatures", live.fused, offline.fused, "K", noise)
    add("standard deviations", live.fused_std, offline.fused_std, "K", noise)
    add("predicted temperatures", live.free_temperature, offline.free_temperature, "K", noise)
    for mode, a, b in (("free run", live.free, offline.free), ("soft sensor", live.soft, offline.soft)):
        for name, key, unit in RESIDUAL_SIGNALS:
            add(f"{name.replace('_', ' ')}, {mode}", a[name], b[name], unit, rig.sensors[key].noise)
    return found


def sentence(apart: Sequence[Difference]) -> str:
    """The largest differences in two sentences: how large, and what they come from."""
    by_name = {d.name: d for d in apart}
    fused, predicted = (by_name.get(f"{which} temperatures") for which in ("fused", "predicted"))
    signals = [d for d in apart if "," in d.name and d.in_noise is not None]
    if fused is None or predicted is None or not signals:
        none = [name for name, there in (("fused", fused), ("predicted", predicted)) if there is None]
        return f"cannot be told: in no interval both have {' and '.join([f'{name} temperatures' for name in none] or ['signals'])}"
    worst = max(signals, key=lambda d: d.in_noise)
    unit = shown(worst.unit)
    return (
        f"largest difference at any instant {fused.largest:.2g} K of a fused temperature, {predicted.largest:.2g} K of a predicted one, "
        f"and, counted in noise of a sample, {worst.largest * unit.factor:.2g} {unit.unit} of a signal ({worst.name}; "
        f"{worst.in_noise:.2g} times the noise of that sensor). It comes from when messages arrive: the live soft sensor knows the fused "
        "temperatures that had come by then, one process those of the same instant"
    )
