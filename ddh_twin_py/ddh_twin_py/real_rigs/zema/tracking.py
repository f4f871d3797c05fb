"""Levels and a drifting base tracked together on a grid: forward and backward through a hidden Markov model, compiled; see `levels`."""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.physics.compiled import kernel

_NOTHING = 1e-7  # of the fullest cell's probability, below which a cell is dropped


@kernel
def _diffuse(row, out, weights, half):
    """Add a row over the grid, convolved with 2 half + 1 weights; what would leave the grid stays at its ends."""
    n = row.size
    for i in range(n):
        if row[i] > 0.0:
            for j in range(-half, half + 1):
                out[min(max(i + j, 0), n - 1)] += row[i] * weights[half + j]


@kernel
def _steps_of(drift, step, cells, weights):
    """Weights of a normal step of the base over the grid; their half width."""
    half = min(int(math.ceil(3.5 * drift / step)), cells - 1)
    mass = 0.0
    for j in range(-half, half + 1):
        weights[half + j] = math.exp(-0.5 * (j * step / drift) ** 2)
        mass += weights[half + j]
    for j in range(2 * half + 1):
        weights[j] /= mass
    return half


@kernel
def _changed(rows, stay):
    """Levels stay with probability ``stay`` or become any other one, in place; rows (k, cells), at least two levels."""
    k, cells = rows.shape
    other = (1.0 - stay) / (k - 1)
    for c in range(cells):
        whole = 0.0
        for a in range(k):
            whole += rows[a, c]
        if whole > 0.0:
            for a in range(k):
                rows[a, c] = stay * rows[a, c] + other * (whole - rows[a, c])


@kernel
def track(value, shift, grid, noise, drift, favour, stay, outlier):
    """Log likelihood; by cycle and level: probability, that of no outlier, with it mean and square of what is left; base.

    Cells that hold less than `_NOTHING` of the fullest are dropped on the way forward and never visited on the way back.
    """
    n, k, cells = value.size, shift.size, grid.size
    step = grid[1] - grid[0]
    forward = np.zeros((n, k, cells), dtype=np.float32)
    now, moved = np.full((k, cells), 1.0 / (k * cells)), np.zeros((k, cells))
    flat = outlier / (grid[-1] - grid[0] + shift.max() - shift.min())
    peak = (1.0 - outlier) / (math.sqrt(2.0 * math.pi) * noise)
    weights = np.empty(2 * cells + 1)
    seen = np.isfinite(value)
    best = np.ones((n, k))
    best[:, 0] = np.exp(favour)
    total = 0.0
    for t in range(n):
        if t > 0:
            half = _steps_of(drift[t], step, cells, weights)
            moved[:] = 0.0
            for a in range(k):
                _diffuse(now[a], moved[a], weights, half)
            if k > 1:
                _changed(moved, stay)
            now, moved = moved, now
        mass, fullest = 0.0, 0.0
        for a in range(k):
            for c in range(cells):
                if now[a, c] > 0.0:
                    z = (value[t] - shift[a] - grid[c]) / noise
                    now[a, c] *= best[t, a] * (peak * math.exp(-0.5 * z * z) + flat if seen[t] else 1.0)
                    mass += now[a, c]
                    fullest = max(fullest, now[a, c])
        total += math.log(mass)
        for a in range(k):
            for c in range(cells):
                now[a, c] = now[a, c] / mass if now[a, c] > _NOTHING * fullest else 0.0
                forward[t, a, c] = now[a, c]
    probability, inlier = np.zeros((n, k)), np.zeros((n, k))
    first, square, base = np.zeros((n, k)), np.zeros((n, k)), np.zeros(n)
    behind = np.ones((k, cells))
    for t in range(n - 1, -1, -1):
        mass = 0.0
        for a in range(k):
            for c in range(cells):
                mass += forward[t, a, c] * behind[a, c]
        moved[:] = 0.0
        for a in range(k):
            for c in range(cells):
                if forward[t, a, c] > 0.0:
                    share = forward[t, a, c] * behind[a, c] / mass
                    probability[t, a] += share
                    base[t] += share * grid[c]
                    if not seen[t]:
                        moved[a, c] = behind[a, c] * best[t, a]
                        continue
                    left = value[t] - shift[a] - grid[c]
                    inside = peak * math.exp(-0.5 * (left / noise) ** 2)
                    of_inlier = share * inside / (inside + flat)
                    inlier[t, a] += of_inlier
                    first[t, a] += of_inlier * left
                    square[t, a] += of_inlier * left * left
                    moved[a, c] = behind[a, c] * best[t, a] * (inside + flat)
        if t == 0:
            break
        if k > 1:
            _changed(moved, stay)
        half = _steps_of(drift[t], step, cells, weights)
        highest = 0.0
        for a in range(k):
            for c in range(cells):
                behind[a, c] = 0.0
                if forward[t - 1, a, c] > 0.0:
                    for j in range(-half, half + 1):
                        behind[a, c] += weights[half + j] * moved[a, min(max(c + j, 0), cells - 1)]
                    highest = max(highest, behind[a, c])
        behind /= highest
    return total, probability, inlier, first, square, base
