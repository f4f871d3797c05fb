"""One step of a linear Kalman filter: compiled, allocation-free, for any number of states.

Prediction x <- F x + B u, P <- F P F^T + Q; readings with independent noise are applied one by
one, each with K = P h^T / (h P h^T + r), x <- x + K (z - h x), P <- P - K (h P). The last is
computed on one triangle and mirrored, so that P stays symmetric to the last bit; with r > 0 it
takes away a matrix of rank one that is never more than P holds along h.

Kalman, J. Basic Eng. 82 (1960) 35; one reading at a time: Bierman, Factorization Methods (1977).
"""

from __future__ import annotations

from ddh_twin_py.physics.compiled import kernel


@kernel
def kalman_step(x, covariance, transition, input_matrix, process, reading_matrix, noise, control, readings, work):
    """Predict and update, in place on x (n) and covariance (n, n).

    Args:
        transition: F, (n, n). input_matrix: B, (n, k). process: Q, (n, n), symmetric.
        reading_matrix: H, (m, n). noise: variances of the readings, (m,), above 0.
        control: u, (k,). readings: z, (m,); what is not finite is left out.
        work: scratch, (2 n + 1, n).
    """
    n = x.shape[0]
    half, mirror, row = work[:n], work[n:2 * n], work[2 * n]
    for i in range(n):
        value = 0.0
        for j in range(n):
            value += transition[i, j] * x[j]
            mirror[j, i] = transition[i, j]
            half[i, j] = 0.0
        for j in range(control.shape[0]):
            value += input_matrix[i, j] * control[j]
        row[i] = value
    for i in range(n):
        x[i] = row[i]
        for k in range(n):
            factor = transition[i, k]
            for j in range(n):
                half[i, j] += factor * covariance[k, j]
    for i in range(n):
        for j in range(n):
            row[j] = process[i, j]
        for k in range(n):
            factor = half[i, k]
            for j in range(i + 1):
                row[j] += factor * mirror[k, j]
        for j in range(i + 1):
            covariance[i, j] = row[j]
    for i in range(n):
        for j in range(i):
            covariance[j, i] = covariance[i, j]
    for r in range(readings.shape[0]):
        if not abs(readings[r]) < 1e300:
            continue
        left = readings[r]
        for j in range(n):
            row[j] = 0.0
        for i in range(n):
            factor = reading_matrix[r, i]
            if factor != 0.0:
                left -= factor * x[i]
                for j in range(n):
                    row[j] += factor * covariance[i, j]
        variance = noise[r]
        for i in range(n):
            variance += reading_matrix[r, i] * row[i]
        inverse = 1.0 / variance
        for i in range(n):
            gain = row[i] * inverse
            x[i] += gain * left
            for j in range(i):
                value = covariance[i, j] - gain * row[j]
                covariance[i, j] = value
                covariance[j, i] = value
            covariance[i, i] -= gain * row[i]
