"""Root mean squares, intervals over seeds, rank correlation with its uncertainty. Random generators are arguments."""

from itertools import permutations
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import rankdata

__all__ = ["Interval", "RankCorrelation", "mean_interval", "rank_correlation", "ratio_interval", "rms"]

Array = NDArray[np.float64]
_DRAWS = 2000
_ENDS = (5.0, 95.0)  # %
_ALL_PERMUTATIONS_UP_TO = 8


class Interval(NamedTuple):
    """An estimate with its 90 % interval."""

    value: float
    low: float
    high: float


class RankCorrelation(NamedTuple):
    """Spearman's rho, its 90 % bootstrap interval, and the share of permutations with a rho at least as large."""

    rho: float
    low: float
    high: float
    p_value: float
    pairs: int


def rms(values: Array) -> float:
    """Return the root mean square of what is there; NaN where nothing is."""
    there = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(there**2))) if there.size else float("nan")


def mean_interval(values: ArrayLike, rng: np.random.Generator) -> Interval:
    """Return the mean of (K,) values with its bootstrap interval; infinite or missing ones make it NaN."""
    return ratio_interval(values, np.ones_like(np.asarray(values, dtype=np.float64)), rng)


def ratio_interval(above: ArrayLike, below: ArrayLike, rng: np.random.Generator) -> Interval:
    """Return mean(above) / mean(below) of pairs (K,), with the interval from drawing pairs anew."""
    a, b = np.asarray(above, dtype=np.float64), np.asarray(below, dtype=np.float64)
    if a.size == 0 or not (np.all(np.isfinite(a)) and np.all(np.isfinite(b))):
        return Interval(np.nan, np.nan, np.nan)
    drawn = rng.integers(a.size, size=(_DRAWS, a.size))
    ratios = a[drawn].mean(axis=1) / b[drawn].mean(axis=1)
    low, high = np.percentile(ratios, _ENDS)
    return Interval(float(a.mean() / b.mean()), float(low), float(high))


def rank_correlation(x: ArrayLike, y: ArrayLike, rng: np.random.Generator) -> RankCorrelation:
    """Return Spearman's rank correlation of (K,) pairs, K >= 3.

    Its interval is from drawing pairs anew, draws in which all are alike left out; the p-value is one-sided, over all
    permutations up to eight pairs and over random ones beyond.
    """
    a, b = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
    if a.shape != b.shape or a.ndim != 1 or a.size < 3 or not np.all(np.isfinite(a + b)):
        raise ValueError(f"rank correlation: expected at least 3 finite pairs; found shapes {a.shape} and {b.shape}")
    rho = _spearman(a, b)
    drawn = rng.integers(a.size, size=(_DRAWS, a.size))
    scattered = np.array([_spearman(a[i], b[i]) for i in drawn])
    low, high = np.nanpercentile(scattered, _ENDS)
    if a.size <= _ALL_PERMUTATIONS_UP_TO:
        orders = np.array(list(permutations(range(a.size))))
    else:
        orders = np.array([rng.permutation(a.size) for _ in range(_DRAWS)])
    ranks_a, ranks_b = (rankdata(x) - 0.5 * (x.size + 1) for x in (a, b))
    shuffled = ranks_b[orders] @ ranks_a / np.sqrt(np.sum(ranks_a**2) * np.sum(ranks_b**2))
    reached = shuffled >= rho - 1e-12
    return RankCorrelation(rho, float(low), float(high), float(np.mean(reached)), a.size)


def _spearman(a: Array, b: Array) -> float:
    if np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return float("nan")
    return float(np.corrcoef(rankdata(a), rankdata(b))[0, 1])
