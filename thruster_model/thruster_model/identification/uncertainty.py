"""Covariance of fitted parameters that stays honest when residuals are not white.

The estimate solves sum_i s_i = 0 with scores s_i = J_i^T w_i r_i. Its covariance is A^-1 B A^-1 with A the Hessian
and B the long-run covariance of the scores, summed per instant over all signals and estimated within each
experiment by Newey and West (1987, doi:10.2307/1913610) with the bandwidth of Andrews (1991, doi:10.2307/2938229).
The prior adds its precision to both.
"""

import numpy as np
from numpy.typing import NDArray

__all__ = ["autocorrelation_time", "newey_west", "sandwich_covariance"]

Array = NDArray[np.float64]


def autocorrelation_time(series: Array) -> float:
    """Return the integrated autocorrelation time in samples, at least 1; gaps (NaN) are passed over.

    1 + 2 sum rho_k up to the first k at which rho_k drops below two standard errors of white noise.
    """
    centred = series - np.nanmean(series)
    known = np.isfinite(centred)
    filled = np.where(known, centred, 0.0)
    size = filled.size
    transform = np.fft.rfft(filled, 2 * size)
    pairs = np.fft.rfft(known.astype(np.float64), 2 * size)
    covariance = np.fft.irfft(transform * np.conj(transform))[:size]
    counts = np.round(np.fft.irfft(pairs * np.conj(pairs))[:size])
    if covariance[0] <= 0.0:
        return 1.0
    rho = (covariance / np.maximum(counts, 1.0)) / (covariance[0] / counts[0])
    limit = 2.0 / np.sqrt(counts[0])
    below = np.flatnonzero((rho < limit) | (counts < 10))
    last = int(below[0]) if below.size else size
    return float(max(1.0, 1.0 + 2.0 * np.sum(rho[1:last])))


def newey_west(scores: Array, lag: int) -> Array:
    """Return the Bartlett-weighted long-run covariance (P, P) of the sum of scores (M, P)."""
    result = scores.T @ scores
    for k in range(1, min(lag, scores.shape[0] - 1) + 1):
        cross = scores[k:].T @ scores[:-k]
        result += (1.0 - k / (lag + 1.0)) * (cross + cross.T)
    return np.asarray(result)


def bandwidth(scores: Array) -> int:
    """Return the lag of the Bartlett kernel by Andrews' plug-in with a first-order autoregression per column."""
    x, y = scores[:-1], scores[1:]
    power = np.sum(x * x, axis=0)
    use = power > 0
    if not np.any(use):
        return 0
    rho = np.clip(np.sum(x * y, axis=0)[use] / power[use], -0.97, 0.97)
    variance = np.mean((y[:, use] - rho * x[:, use]) ** 2, axis=0)
    weight = 1.0 / np.maximum(np.mean(scores[:, use] ** 2, axis=0), 1e-300) ** 2
    numerator = np.sum(weight * 4.0 * rho**2 * variance**2 / ((1.0 - rho) ** 6 * (1.0 + rho) ** 2))
    denominator = np.sum(weight * variance**2 / (1.0 - rho) ** 4)
    return int(min(np.ceil(1.1447 * (numerator / denominator * scores.shape[0]) ** (1.0 / 3.0)), scores.shape[0] // 3))


def sandwich_covariance(hessian: Array, scores: list[Array], prior_precision: Array) -> Array:
    """Return the covariance (P, P) of the estimate.

    Args:
        hessian: of the data's part of the cost, (P, P).
        scores: of each experiment, summed per instant over its signals, each (M, P).
        prior_precision: (P, P).
    """
    size = hessian.shape[0]
    middle = prior_precision.copy()
    count = sum(s.shape[0] for s in scores)
    for series in scores:
        middle += newey_west(series, bandwidth(series))
    middle *= count / max(count - size, 1)
    inverse = np.linalg.pinv(hessian + prior_precision, hermitian=True)
    return np.asarray(inverse @ middle @ inverse)
