"""The condition of the ZeMA rig's components in every cycle, from nothing but the record and the network fitted to known cycles.

The network says of each cycle what leakage, switching time, stored oil and cooler effectiveness it would take to see what was seen.
These quantities jump where a condition was changed and drift where the network is not quite the rig; `levels` tells the one from the other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ddh_twin_py.real_rigs.figures import surely_smaller
from ddh_twin_py.real_rigs.zema import levels, network
from ddh_twin_py.real_rigs.zema.features import Features
from ddh_twin_py.real_rigs.zema.levels import Levels, Series

COMPONENTS = ("cooler", "valve", "pump_leakage", "accumulator")
PRIOR_WORSE = 0.6
"""Probability that a component is not in its best condition where nothing is seen of it."""
HIGH = [1, 2]
"""Of `features.STEPS`, between the higher loads."""
WRONG, WRONG_UNCONFIRMED = 0.02, 0.3
"""Probability that the levels found are not the component's, where cycles that took no part confirm them and where they do not: then the
prior holds."""
COUNTS = {"cooler": (2, 3), "valve": (2, 3, 4), "pump_leakage": (2, 3), "accumulator": (2, 3, 4)}
SIGNS = {"cooler": (-1.0,), "valve": (1.0, -1.0), "pump_leakage": (1.0,), "accumulator": (-1.0,)}
_LEAST = {"cooler": 0.02, "valve": 0.003, "pump_leakage": 0.04, "accumulator": 0.04}  # as in `Estimates`
_DRIFT = {"cooler": 0.003, "valve": 0.0004, "pump_leakage": 0.001, "accumulator": 0.006}  # a cycle, before the known cycles are asked
_WITH_TEMPERATURE = {"cooler": 0.005, "valve": 0.0003, "pump_leakage": 0.01, "accumulator": 0.002}  # drift for each K that the oil changed
_THREADS = 2
_DRIFT_WEIGHT = 2.0  # steps between known blocks that the drift above is worth
_ABOUT = 4  # cycles before and after a jump of the valve's times, and about a cycle whose pre-charge lies above the lower loads
_LOW, _LOWER = [0, 3], [0, 4]  # of `features.STEPS`, between the lower loads; those of `features.LOADS`
_EMPTY = 0.8  # of what the gas law says from the higher steps, below which the lower steps show an accumulator that was empty
_ONE = 3.0  # of the least distance of levels, within which known blocks count as one level
_SHOWS = 2.0  # log likelihood of the best level over others where they do; the other way round where they should and do not


@dataclass(frozen=True)
class Estimates:
    """What the network makes of each cycle by itself, (n,) each.

    Attributes:
        cooler: effectiveness. pump_leakage: L/min at 155 bar. accumulator: log of the gas' p_0 V_0 over that of the known cycles.
        highest: whether the pre-charge shows as the highest (1), does not (-1), or cannot (0).
        switching: s, closing and opening, (n, 2), over those of the known cycles. oil: degC.
    """

    cooler: np.ndarray
    pump_leakage: np.ndarray
    accumulator: np.ndarray
    highest: np.ndarray
    switching: np.ndarray
    oil: np.ndarray


@dataclass(frozen=True)
class Conditions:
    """Conditions of every cycle.

    Attributes:
        estimate: component to estimated condition (n,), larger is better but for ``pump_leakage``; None where it cannot be observed.
        worse: component to probability that it is not in its best condition, (n,). verdict: component or ``none``, (n,).
        found: component to its levels. confirmed: whether levels surely make cycles better known that took no part.
        direction: of the valve's closing and opening times in its lag.
    """

    estimate: dict[str, np.ndarray | None]
    worse: dict[str, np.ndarray]
    verdict: list[str]
    found: dict[str, Levels]
    confirmed: dict[str, bool]
    direction: np.ndarray


def estimates(f: Features, p: np.void, known: np.ndarray) -> Estimates:
    """The network turned round, cycle by cycle.

    Args:
        p: parameter record fitted to the known cycles. known: those cycles, (n,) true.
    """
    oil = 0.5 * (f.temperature[:, 0] + f.temperature[:, 1])
    cooler = (f.temperature[:, 2] - f.temperature[:, 3]) / np.maximum(f.temperature[:, 2] - float(p["air"]), 1.0)
    missing = float(p["pump_flow"]) - network.slip(f.pressure, oil, p) - f.flow
    leakage = _mean(np.where(f.working, missing / np.sqrt(np.maximum(f.pressure, 1.0) / network.AT_LEAK), np.nan))
    closing = np.stack([f.closing[:, 0], f.closing[:, 1] - float(p["flow_late"])], axis=1).mean(axis=1)
    gas, highest = _gas(f, closing, p, known)
    switching = np.stack([closing - np.nanmean(closing[known]), f.opening - np.nanmean(f.opening[known])], axis=1)
    return Estimates(cooler, leakage, gas, highest, switching, oil)


def _gas(f: Features, closing: np.ndarray, p: np.void, known: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Log of p_0 V_0 over that of the known cycles, and whether the pre-charge shows as the highest (1), does not (-1), or cannot (0).

    Gas without oil has a pressure p_0 T/T_0. Where that lies above the lower loads the accumulator is empty there and stores nothing
    between them, which the highest pre-charge alone reaches; where the oil is as hot and the lower loads as low and it stores as it
    should, the pre-charge is not the highest. An empty accumulator's gas says nothing of p_0 V_0.
    """
    each = f.stored / network.stored(f)
    low, high = _mean(each[:, _LOW]), _mean(each[:, HIGH])
    above = low < _EMPTY * high
    by_rise = (f.rise - closing - float(p["rise_late"])) / (float(p["rise_ratio"]) * network.rise(f))
    logs = [np.log(np.maximum(gas, 1e-3 * float(p["gas"]))) for gas in (high, by_rise)]
    gas = _mean(np.stack([log - np.nanmean(log[known]) for log in logs], axis=1))
    near = np.convolve(above, np.ones(2 * _ABOUT + 1), "same") > 0
    lower = f.pressure[:, _LOWER].mean(axis=1)
    warmth = (273.15 + 0.5 * (f.temperature[:, 0] + f.temperature[:, 1])) / lower  # gas at p_0 T/T_0 against the lower loads
    enough = above.any() and np.isfinite(low) & (warmth > np.median(warmth[above]))
    return np.where(near, np.nan, gas), np.where(above, 1.0, np.where(enough & ~near, -1.0, 0.0))


def _mean(values: np.ndarray) -> np.ndarray:
    """Mean of what there is in each row, (n, m) to (n,); NaN where there is nothing."""
    there = np.isfinite(values)
    count = there.sum(axis=1)
    return np.where(count > 0, np.where(there, values, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)


def direction(switching: np.ndarray) -> np.ndarray:
    """In which proportion closing and opening times (n, 2) jump together: main axis of the jumps, (2,), of length 1, sum above 0."""
    switching = switching[np.isfinite(switching).all(axis=1)]
    n = switching.shape[0]
    jumps = np.array([np.median(switching[t : t + _ABOUT], axis=0) - np.median(switching[t - _ABOUT : t], axis=0)
                      for t in range(_ABOUT, n - _ABOUT + 1)])
    size = np.sum(jumps**2, axis=1)
    peak = np.array([size[i] == size[max(i - _ABOUT, 0) : i + _ABOUT + 1].max() for i in range(size.size)])
    axis = np.linalg.eigh(jumps[peak].T @ jumps[peak])[1][:, -1]
    return axis if axis.sum() >= 0.0 else -axis


def values_of(est: Estimates, axis: np.ndarray) -> dict[str, np.ndarray]:
    """The one quantity in which each component's condition shows, (n,); of the valve along ``axis``, see `direction`."""
    return {"cooler": est.cooler, "valve": est.switching @ axis, "pump_leakage": est.pump_leakage, "accumulator": est.accumulator}


def series_of(component: str, value: np.ndarray, est: Estimates, known: np.ndarray, p: np.void) -> Series:
    """Values of a component with their noise and drift as the known cycles show them.

    Known cycles whose blocks do not lie at one level are taken as no knowledge of this component.
    """
    seen = known & np.isfinite(value)
    places = np.flatnonzero(seen)
    blocks = [block for block in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1) if block.size > 1]
    steps = np.concatenate([np.diff(value[block]) for block in blocks])
    noise = max(1.4826 * float(np.median(np.abs(steps))) / math.sqrt(2.0), 0.1 * _LEAST[component])
    means = np.array([value[block].mean() for block in blocks])
    drift, favour = _DRIFT[component], np.zeros(value.size)
    if np.ptp(means) < _ONE * _LEAST[component]:
        between = np.diff(means) ** 2 / np.diff([block.mean() for block in blocks])
        drift = math.sqrt((_DRIFT_WEIGHT * drift**2 + between.sum()) / (_DRIFT_WEIGHT + between.size))
        favour = np.where(known, levels.KNOWN, 0.0)
    if component == "accumulator":
        favour = favour + _SHOWS * est.highest
    warming = np.abs(np.diff(est.oil, prepend=est.oil[0]))
    warmth = 0.1 * (est.oil - est.oil[known].mean())
    columns, widths = np.zeros((value.size, 0)), np.zeros(0)
    if component == "pump_leakage":
        thin = 1.0 / network.viscosity_ratio(est.oil)
        columns = np.stack([float(p["slip"]) * network.AT_LEAK * (thin - thin[known].mean()), warmth], axis=1)
        widths = np.array([0.5, 0.05])  # share of the slip that does not follow viscosity; L/min per 10 K
    elif component == "accumulator":
        columns, widths = np.stack([warmth, warmth**2], axis=1), np.array([0.05, 0.02])  # per 10 K
    elif component == "valve":
        columns, widths = np.stack([warmth, warmth**2], axis=1), np.array([0.005, 0.002])  # s per 10 K
    return Series(value - value[seen].mean(), noise, np.hypot(drift, _WITH_TEMPERATURE[component] * warming), favour, columns, widths,
                  _LEAST[component])


def conditions(f: Features, p: np.void, known: np.ndarray, progress=None) -> Conditions:
    """Conditions of every cycle of a record.

    Args:
        f: features of consecutive cycles. p: parameter record fitted to the known cycles. known: those cycles, (n,) true.
        progress: told the share done.
    """
    est = estimates(f, p, known)
    axis = direction(est.switching)
    values = values_of(est, axis)
    found: dict[str, Levels] = {}
    confirmed: dict[str, bool] = {}
    with ThreadPoolExecutor(_THREADS) as pool:
        tasks = {c: pool.submit(_found, series_of(c, values[c], est, known, p), COUNTS[c], SIGNS[c]) for c in COMPONENTS}
        for component, task in tasks.items():
            found[component], confirmed[component] = task.result()
            if progress is not None:
                progress(len(found) / len(COMPONENTS))
    time = float(axis @ [p["closing"], p["opening"]])
    told = {"cooler": lambda s: est.cooler[known].mean() + s, "valve": lambda s: abs(time) / (abs(time) + np.abs(s)),
            "pump_leakage": lambda s: s, "accumulator": np.exp}
    estimate, worse = {}, {}
    for component, one in found.items():
        seen = one.shift.size > 1
        estimate[component] = told[component](one.expected) if seen else None
        wrong = WRONG if confirmed[component] else WRONG_UNCONFIRMED
        worse[component] = wrong * PRIOR_WORSE + (1.0 - wrong) * one.worse if seen else np.full(est.oil.size, PRIOR_WORSE)
    return Conditions(estimate, worse, _verdicts(worse, found), found, confirmed, axis)


def _found(series: Series, counts: Sequence[int], signs: Sequence[float]) -> tuple[Levels, bool]:
    """Levels, and whether cycles that took no part confirm them."""
    found = levels.find(series, counts, signs)
    return found, confirmed_by(series, found)


def confirmed_by(series: Series, found: Levels) -> bool:
    """Whether levels surely make cycles better known that took no part; see `levels.left_out`."""
    if found.shift.size == 1:
        return False
    before, after = levels.left_out(series, found)
    return surely_smaller([{"value": before}], [{"value": after}])


def _verdicts(worse: dict[str, np.ndarray], found: dict[str, Levels]) -> list[str]:
    """The component that is most surely not in its best condition, of equal ones that farther from it; none where all may well be in it."""
    seen = [c for c in COMPONENTS if found[c].shift.size > 1]
    n = next(iter(worse.values())).size
    out = []
    for t in range(n):
        best = math.prod(1.0 - worse[c][t] for c in seen)
        if not seen or best >= 0.5:
            out.append("none")
            continue
        depth = {c: found[c].expected[t] / found[c].shift[-1] for c in seen}
        out.append(max(seen, key=lambda c: (round(worse[c][t], 2), depth[c])))
    return out


def as_csv(conditions: Conditions) -> str:
    """One line a cycle: cycle, estimated conditions, probabilities, verdict; empty where nothing can be observed."""
    heads = ["cycle", "cooler", "valve", "accumulator", "pump_leakage", "p_cooler", "p_valve", "p_pump_leakage", "p_accumulator", "verdict"]
    lines = [",".join(heads)]
    for t, verdict in enumerate(conditions.verdict):
        cells = [str(t)]
        for component in ("cooler", "valve", "accumulator", "pump_leakage"):
            values = conditions.estimate[component]
            cells.append("" if values is None else f"{values[t]:.3f}")
        cells += [f"{conditions.worse[c][t]:.4f}" for c in ("cooler", "valve", "pump_leakage", "accumulator")]
        lines.append(",".join([*cells, verdict]))
    return "\n".join(lines) + "\n"
