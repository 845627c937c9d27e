"""Kalman filter and Rauch-Tung-Striebel smoother of a time-varying linear model.

    x_{k+1} = F_k x_k + w_k,  w_k ~ N(0, Q_k);      y_k = H x_k + e_k,  e_k ~ N(0, diag R)

Channels of one sample are independent given the state and are taken in one after the other. Missing measurements
are NaN: they are predicted and not used.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thruster_model.compilation import compiled

__all__ = ["LinearModel", "Smoothed", "log_likelihood", "smooth"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class LinearModel:
    """Matrices of the model.

    Attributes:
        F, Q: transition and process noise from sample k to k + 1, (N, n, n).
        H: what each channel measures of the state (m, n).
        R: variances of the measurement noise (m,).
        mean, covariance: belief before the first measurement, (n,) and (n, n).
    """

    F: Array
    Q: Array
    H: Array
    R: Array
    mean: Array
    covariance: Array


@dataclass(frozen=True, kw_only=True)
class Smoothed:
    """Beliefs given all measurements.

    Attributes:
        mean: (N, n).
        covariance: (N, n, n).
        innovation: measured less predicted from the past, in standard deviations (N, m); NaN where not measured.
        log_likelihood: of all measurements.
    """

    mean: Array
    covariance: Array
    innovation: Array
    log_likelihood: float


@compiled
def _filter(y, F, Q, H, R, mean, covariance, means, covariances, priors, prior_covariances, innovation, keep):  # type: ignore[no-untyped-def]
    """Run forward; beliefs are kept for the smoother where `keep` is set. Explicit loops: the matrices are tiny."""
    n = mean.size
    x, P = mean.copy(), covariance.copy()
    FP, gain, next_x = np.zeros((n, n)), np.zeros(n), np.zeros(n)
    total = 0.0
    for k in range(y.shape[0]):
        if keep:
            priors[k], prior_covariances[k] = x, P
        for c in range(y.shape[1]):
            if not np.isfinite(y[k, c]):
                continue
            S, expected = R[c], 0.0
            for i in range(n):
                expected += H[c, i] * x[i]
                gain[i] = 0.0
                for j in range(n):
                    gain[i] += P[i, j] * H[c, j]
                S += H[c, i] * gain[i]
            error = y[k, c] - expected
            total -= 0.5 * (np.log(2.0 * np.pi * S) + error * error / S)
            innovation[k, c] = error / np.sqrt(S)
            for i in range(n):
                x[i] += gain[i] * error / S
                for j in range(n):
                    P[i, j] -= gain[i] * gain[j] / S
        if keep:
            means[k], covariances[k] = x, P
        for i in range(n):
            next_x[i] = 0.0
            for j in range(n):
                next_x[i] += F[k, i, j] * x[j]
                FP[i, j] = 0.0
                for m in range(n):
                    FP[i, j] += F[k, i, m] * P[m, j]
        for i in range(n):
            x[i] = next_x[i]
            for j in range(i + 1):
                value = Q[k, i, j]
                for m in range(n):
                    value += FP[i, m] * F[k, j, m]
                P[i, j] = value
                P[j, i] = value
    return total


def log_likelihood(y: Array, model: LinearModel) -> float:
    """Return the log likelihood of the measurements y (N, m)."""
    n = model.mean.size
    none, nones = np.empty((0, n)), np.empty((0, n, n))
    innovation = np.empty(y.shape)
    m = model
    return float(_filter(y, m.F, m.Q, m.H, m.R, m.mean, m.covariance, none, nones, none, nones, innovation, False))


def smooth(y: Array, model: LinearModel) -> Smoothed:
    """Return the beliefs given all measurements y (N, m)."""
    N, n = y.shape[0], model.mean.size
    means, priors = np.empty((N, n)), np.empty((N, n))
    covariances, prior_covariances = np.empty((N, n, n)), np.empty((N, n, n))
    innovation = np.full(y.shape, np.nan)
    m = model
    total = _filter(
        y, m.F, m.Q, m.H, m.R, m.mean, m.covariance, means, covariances, priors, prior_covariances, innovation, True
    )
    for k in range(N - 2, -1, -1):
        G = np.linalg.solve(prior_covariances[k + 1], m.F[k] @ covariances[k]).T
        means[k] += G @ (means[k + 1] - priors[k + 1])
        covariances[k] += G @ (covariances[k + 1] - prior_covariances[k + 1]) @ G.T
    return Smoothed(mean=means, covariance=covariances, innovation=innovation, log_likelihood=float(total))
