"""The smoother: what comes later makes it surer and never wrong, and it is the filter's at the end."""

import numpy as np
import pytest
from ddh_twin_py.estimation.consistency import one_seed
from ddh_twin_py.estimation.fusion import smoother
from ddh_twin_py.estimation.fusion.smoother import Trace, back
from ddh_twin_py.estimation.fusion.uncertain_parameters import N_UNCERTAIN, N_UNKNOWN_HEATS, UNKNOWN_HEAT_AT, UNKNOWN_HEAT_TIME
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.physics.thermal_network import N
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from support.simulated import DUTY, simulated

SEEDS = (0, 1, 2)


@pytest.fixture(scope="module")
def rig():
    return load_rig()


@pytest.fixture(scope="module")
def smoothed(rig):
    return replay(simulated(0)[0], rig, smooth=True)


def test_it_ends_as_the_filter_and_is_never_less_sure(smoothed):
    rows = smoothed.smoothed_row
    assert rows.size > 100 and np.all(np.diff(rows) > 0)
    np.testing.assert_allclose(smoothed.smoothed[-1], smoothed.fused[rows[-1]], atol=1e-9)
    np.testing.assert_allclose(smoothed.smoothed_std[-1], smoothed.fused_std[rows[-1]], atol=1e-9)
    assert np.all(smoothed.smoothed_std <= smoothed.fused_std[rows] + 1e-6)
    assert np.all(smoothed.smoothed_std[0] < smoothed.fused_std[rows[0]])
    assert smoothed.smoothed_std.min() > 0.0


def test_the_filter_does_not_feel_it(smoothed, rig):
    plain = replay(simulated(0)[0], rig)
    assert plain.fused.tobytes() == smoothed.fused.tobytes() and plain.smoothed_row.size == 0


def test_errors_are_smaller_over_seeds(rig):
    """Mean squared error of all nodes, hidden ones included, over rigs drawn within tolerance."""
    duty = load_duty(DUTY / "mixed.yaml")
    errors = [one_seed(rig, duty, seed, 120.0) for seed in SEEDS]
    assert np.sum([e.smoothed_squared for e in errors]) < np.sum([e.squared for e in errors])
    assert 0.4 < np.mean([e.smoothed_square.mean() for e in errors]) < 2.0


def test_it_agrees_with_rauch_tung_and_striebel():
    """A random linear system of the filter's shape: adjoint recursion against the inverse of the predicted covariance."""
    rng = np.random.default_rng(3)
    m, steps, elapsed = 2, 12, 1.0
    d, size = N + m, N + 2 * m + N_UNCERTAIN
    width = d + N_UNCERTAIN
    mean, covariance = rng.normal(size=size), np.diag(rng.uniform(0.5, 2.0, size))
    trace, filtered, predicted, moves = Trace(), [], [], []
    kept = np.ones(size)
    kept[d + m + UNKNOWN_HEAT_AT:] = np.exp(-elapsed / UNKNOWN_HEAT_TIME)
    for _ in range(steps):
        transition = np.concatenate([0.8 * np.eye(d), np.zeros((d, N_UNCERTAIN))], axis=1) + rng.normal(0.0, 0.02, (d, width))
        transition = transition.astype(np.float32).astype(float)
        move = np.diag(kept)
        move[:d, :d], move[:d, d + m:] = transition[:, :d], transition[:, d:]
        move[:d, d: d + m] = 0.0
        mean = move @ mean
        covariance = move @ covariance @ move.T + 0.1 * np.eye(size)
        predicted.append((mean, covariance))
        moves.append(move)
        trace.moved(elapsed, transition)
        gains, left, spread, sensor = [], [], [], np.array([0, 1])
        for k in sensor:
            pick = np.zeros(size)
            pick[N + k] = pick[d + k] = 1.0
            gain = (covariance @ pick).astype(np.float32).astype(float)
            variance = pick @ covariance @ pick + 0.01
            innovation = rng.normal(0.0, np.sqrt(variance))
            mean = mean + gain / variance * innovation
            covariance = covariance - np.outer(gain, gain) / variance
            gains.append(gain)
            left.append(innovation)
            spread.append(np.sqrt(variance))
        trace.read(np.array(gains), sensor, np.array(left), np.array(spread))
        trace.estimated(len(filtered), mean, mean[-N_UNKNOWN_HEATS:], covariance)
        filtered.append((mean, covariance))
    x, p = filtered[-1]
    expected = [(x, p)]
    for k in range(steps - 2, -1, -1):
        gain = filtered[k][1] @ moves[k + 1].T @ np.linalg.inv(predicted[k + 1][1])
        x, p = filtered[k][0] + gain @ (x - predicted[k + 1][0]), filtered[k][1] + gain @ (p - predicted[k + 1][1]) @ gain.T
        expected.append((x, p))
    said = trace.smooth()
    assert said.row.tolist() == list(range(steps))
    for row, (x, p) in zip(said.row[::-1], expected, strict=True):
        sigma = np.sqrt(np.diagonal(p))
        np.testing.assert_allclose(said.temperature[row], x[:N], atol=1e-4)
        np.testing.assert_allclose(said.temperature_std[row], sigma[:N], atol=1e-4)
        np.testing.assert_allclose(said.heat[row], x[-N_UNKNOWN_HEATS:], atol=1e-4)
        np.testing.assert_allclose(said.heat_std[row], sigma[-N_UNKNOWN_HEATS:], atol=1e-4)
    assert back.signatures  # it ran compiled


def test_what_is_on_disk_is_smoothed_alike_and_memory_stays_bounded(smoothed, rig, monkeypatch):
    monkeypatch.setattr(smoother, "_BLOCK", 16)
    kept, smooth = [], Trace.smooth
    monkeypatch.setattr(Trace, "smooth", lambda trace: kept.append((len(trace), *trace.nbytes)) or smooth(trace))
    again = replay(simulated(0)[0], rig, smooth=True)
    assert again.smoothed.tobytes() == smoothed.smoothed.tobytes() and again.smoothed_std.tobytes() == smoothed.smoothed_std.tobytes()
    (steps, memory, file), = kept
    assert steps == 240 and memory < 16 * 60e3 and file > 5 * memory
    assert 3600 * file / steps < 150e6  # bytes on disk for an hour
