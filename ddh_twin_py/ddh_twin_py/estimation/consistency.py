"""Is the filter as wrong as it says: rigs drawn from its own priors, many seeds, chi-square bands.

Each seed is a rig drawn within the sheet's tolerances, at a start, with unknown heats, sensor lags,
offsets and noise drawn as the filter believes them. Two statistics, each averaged over the seeds
at one instant and held against the central 95 % band of its chi-square distribution over S seeds:

    NEES = e^T P^-1 e     all node temperatures with their whole covariance block, dof S times their number
    NIS  = r^2 / s        each reading in the sequence in which it is applied, dof: their number

Bar-Shalom, Li, Kirubarajan, Estimation with applications to tracking and navigation (2001), 5.4.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np
from scipy.stats import binom, chi2

from ddh_twin_py.estimation.fusion.look_ahead import HOT_SPOT_SHARE, HOT_SPOT_SPREAD, hot_spot, with_hot_spot
from ddh_twin_py.estimation.fusion.outvoted import colder_than_all
from ddh_twin_py.estimation.fusion.state import start_covariance
from ddh_twin_py.estimation.fusion.uncertain_parameters import N_UNKNOWN_HEATS, UNKNOWN_HEAT_SHARE, UNKNOWN_HEAT_STD, UNKNOWN_HEAT_TIME
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.estimation.sensors import NODE_INDEX, SENSORS
from ddh_twin_py.physics.thermal_network import N, NODES
from ddh_twin_py.rig import Rig
from ddh_twin_py.telemetry.recording import Recording, Stream
from ddh_twin_py.twin.duty import Duty
from ddh_twin_py.twin.simulated_rig import CHUNK, SimulatedRig, Surroundings

LEVEL = 0.95
JUDGED = np.array([i for i, node in enumerate(NODES) if not node.startswith("valve_")])
"""Nodes in NEES: all but the valve block's, which on the reference sheet has neither heat nor flow."""
HIDDEN = "motor_winding"
"""The sensor that is withheld in the second run of each seed; the winding's hot spot is judged then."""
LEAST_RIGS, LEAST_INSTANTS = 10, 20
"""Fewer show nothing to rely on: from so many rigs on a hot spot twice as wrong as said is mostly found, and of so many instants one is
expected outside of its band."""
AS_SAID, TOO_LITTLE = "The estimate is as wrong as it says", "Too little was run to say whether the estimate is as wrong as it says"
"""Begins of a verdict that finds nothing wrong."""


@dataclass(frozen=True)
class SeedErrors:
    """One seed: at k instants.

    Attributes:
        time: s, (k,). nees: of the nodes `JUDGED`, (k,). nis, readings: sum and number of readings since the instant before, (k,).
        hot_spot: error over standard deviation of the winding's hottest point, its sensor withheld, (k,).
        hot_spot_std: K, (k,). smoothed_square: mean squared error over standard deviation of the nodes, smoothed, (j,).
        squared, smoothed_squared: K^2, mean squared error over the nodes `JUDGED` and instants, filtered and smoothed.
    """

    time: np.ndarray
    nees: np.ndarray
    nis: np.ndarray
    readings: np.ndarray
    hot_spot: np.ndarray
    hot_spot_std: np.ndarray
    smoothed_square: np.ndarray
    squared: float
    smoothed_squared: float


@dataclass(frozen=True)
class Band:
    """A statistic over seeds: mean over its dof, band of one instant, share of the instants inside."""

    mean: float
    lower: float
    upper: float
    inside: float
    instants: int


def drawn_surroundings(rig: Rig, seed: int) -> Surroundings:
    """Start, unknown heats and sensor lags as the filter believes them; a start is mirrored about the air, which leaves the covariance as
    it is, where the motor would be colder than all around it."""
    rng = np.random.default_rng([seed, 1])
    start = np.linalg.cholesky(start_covariance()) @ rng.standard_normal(N)  # eigenvectors differ from machine to machine
    read = list(NODE_INDEX.values())
    start = min(start, -start, key=lambda drawn: colder_than_all(drawn[read], 0.0).max())
    kept = np.exp(-CHUNK / UNKNOWN_HEAT_TIME)
    path = [rng.normal(0.0, UNKNOWN_HEAT_STD)]

    def heat(now: float) -> np.ndarray:
        while len(path) <= round(now / CHUNK):
            path.append(kept * path[-1] + np.sqrt(1.0 - kept * kept) * rng.normal(0.0, UNKNOWN_HEAT_STD, N_UNKNOWN_HEATS))
        return path[round(now / CHUNK)] @ UNKNOWN_HEAT_SHARE

    quantity = rig.quantities["sensors.temperature.time_constant"]
    lags = quantity.value + quantity.standard_deviation * np.clip(rng.standard_normal(len(SENSORS)), -2.5, 2.5)
    return Surroundings(start, heat, lags)


def simulate_truth(rig: Rig, duty: Duty, seed: int, duration: float) -> tuple[Recording, np.ndarray]:
    """A recording of ``duration`` s, and the true temperatures at the end of each `CHUNK`, K, (k, N)."""
    simulated = SimulatedRig(rig, duty, seed, drawn_surroundings(rig, seed))
    recordings, truth = [], []
    for chunk in simulated.run(duration):
        recordings.append(chunk)
        truth.append(simulated.truth())
    chunks = [dict(chunk.streams()) for chunk in recordings]
    joined = {
        topic: Stream(np.concatenate([c[topic].time for c in chunks]), np.concatenate([c[topic].values for c in chunks]), stream.fields)
        for topic, stream in chunks[0].items()
    }
    return recordings[0].with_streams(joined), np.array(truth)


def one_seed(rig: Rig, duty: Duty, seed: int, duration: float, every: float = 10.0) -> SeedErrors:
    """Simulate a rig and estimate it, with all sensors and without the winding's."""
    recording, truth = simulate_truth(rig, duty, seed, duration)
    result = replay(recording, rig, smooth=True, covariances=True)
    blind = replay(recording, rig, without=(HIDDEN,))
    rows = result.smoothed_row
    at = np.round(result.time[rows] / CHUNK).astype(int) - 1
    chosen = np.flatnonzero((at >= 0) & (at < len(truth)) & (np.round(result.time[rows], 3) % every == 0.0))
    rows, at = rows[chosen], at[chosen]
    error = (result.fused[rows] - truth[at])[:, JUDGED]
    nees = [float(e @ np.linalg.solve(p, e)) for e, p in zip(error, result.covariance[chosen][:, JUDGED[:, None], JUDGED], strict=True)]
    smoothed_at = np.round(result.time[result.smoothed_row] / CHUNK).astype(int) - 1
    smoothed_error = result.smoothed - truth[np.minimum(smoothed_at, len(truth) - 1)]
    smoothed_z = np.mean(np.square(smoothed_error / result.smoothed_std)[:, JUDGED], axis=1)
    filtered_error = result.fused[result.smoothed_row] - truth[np.minimum(smoothed_at, len(truth) - 1)]
    index = np.array([i.index for i in result.innovations])
    square = np.array([((i.measured - i.expected) / i.standard_deviation) ** 2 for i in result.innovations])
    slot = np.searchsorted(rows, index)
    within = slot < len(rows)
    nis = np.bincount(slot[within], square[within], len(rows))
    readings = np.bincount(slot[within], minlength=len(rows))
    share = HOT_SPOT_SHARE + HOT_SPOT_SPREAD * float(np.clip(np.random.default_rng([seed, 2]).standard_normal(), -1.9, 2.5))
    told, std = hot_spot(blind.fused[rows], blind.fused_std[rows], duty.ambient[0])
    true = with_hot_spot(truth[at], duty.ambient[0], share)[:, -1]
    return SeedErrors(result.time[rows], np.array(nees), nis, readings, (told - true) / std, std, smoothed_z,
                      float(np.mean(filtered_error[:, JUDGED] ** 2)), float(np.mean(smoothed_error[:, JUDGED] ** 2)))


def many_seeds(rig: Rig, duty: Duty, seeds: Collection[int], duration: float, every: float = 10.0,
               progress: Callable[[float], None] | None = None) -> list[SeedErrors]:
    """`one_seed` for each of ``seeds``."""
    errors = []
    for done, seed in enumerate(seeds):
        errors.append(one_seed(rig, duty, seed, duration, every))
        if progress is not None:
            progress((done + 1) / len(seeds))
    return errors


def nees_band(errors: list[SeedErrors]) -> Band:
    """NEES per node, averaged over the seeds."""
    total = np.sum([e.nees for e in errors], axis=0)
    lower, upper = chi2.ppf([0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], len(errors) * JUDGED.size)
    dof = len(errors) * JUDGED.size
    inside = float(np.mean((total >= lower) & (total <= upper)))
    return Band(float(total.mean() / dof), float(lower / dof), float(upper / dof), inside, total.size)


def nis_band(errors: list[SeedErrors]) -> Band:
    """NIS per reading, averaged over the seeds."""
    total, dof = np.sum([e.nis for e in errors], axis=0), np.sum([e.readings for e in errors], axis=0)
    lower, upper = chi2.ppf(0.5 - 0.5 * LEVEL, dof), chi2.ppf(0.5 + 0.5 * LEVEL, dof)
    return Band(float(total.sum() / dof.sum()), float(np.median(lower / dof)), float(np.median(upper / dof)),
                float(np.mean((total >= lower) & (total <= upper))), total.size)


def verdict(nees: Band, nis: Band, hot_spot: float, rigs: int) -> str:
    """One sentence: whether errors, innovations and the hidden hot spot are as large as the filter says, or that too little was run to say.

    A mean below its band says that the filter is more wary than it need be, above it that it is too sure. Of the
    ``rigs`` so many must have their hot spot inside as `LEVEL` leaves, but for a chance of 2.5 %: a rig's instants
    depend on each other and count as one.
    """
    told = []
    for name, band in (("errors of all nodes", nees), ("innovations", nis)):
        size = "smaller than" if band.mean <= band.lower else "larger than" if band.mean >= band.upper else "as large as"
        told.append(f"{name} are {size} said")
    least = float(binom.ppf(0.5 - 0.5 * LEVEL, rigs, LEVEL)) / rigs
    told.append(f"the hidden hot spot lies in its {100.0 * LEVEL:.0f} % interval {100.0 * hot_spot:.0f} % of the time, at least "
                f"{100.0 * least:.0f} % are expected of {rigs} rigs")
    sound = all("as large as" in words for words in told[:2]) and hot_spot >= least
    few = rigs < LEAST_RIGS or nees.instants < LEAST_INSTANTS
    held = f"{rigs} rig{'s' * (rigs != 1)}, {nees.instants} instants of each; {LEAST_RIGS} and {LEAST_INSTANTS} are the least"
    said = f"{TOO_LITTLE} ({held})" if few else AS_SAID
    return f"{said if sound else 'The estimate is not as wrong as it says'}: {'; '.join(told)}."


def hot_spot_inside(errors: list[SeedErrors]) -> float:
    """Share of seeds and instants in which the winding's hottest point lies within its 95 % interval, its sensor withheld."""
    return float(np.mean([np.abs(e.hot_spot) <= 1.96 for e in errors]))

