"""Intervals and curves for the scores of a blind check."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["Limit", "Share", "calibration_error", "detection_limit", "limit_without", "share"]

Array = NDArray[np.float64]

_Z = 1.959963984540054  # 95 %
_FOUND = 0.9
_RIDGE = 0.003  # keeps the slope finite where sizes separate found from not found


@dataclass(frozen=True)
class Share:
    """How many of how many, with Wilson's 95 % interval."""

    hits: int
    of: int

    @property
    def value(self) -> float:
        """The share; NaN of none."""
        return self.hits / self.of if self.of else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson's score interval at 95 %."""
        if not self.of:
            return float("nan"), float("nan")
        z2 = _Z * _Z
        centre = (self.hits + 0.5 * z2) / (self.of + z2)
        half = _Z / (self.of + z2) * np.sqrt(self.hits * (self.of - self.hits) / self.of + 0.25 * z2)
        return max(0.0, float(centre - half)), min(1.0, float(centre + half))


def share(flags: Sequence[bool]) -> Share:
    """Return how many of the flags are set."""
    return Share(sum(map(bool, flags)), len(flags))


@dataclass(frozen=True, kw_only=True)
class Limit:
    """The size that is found 9 times in 10.

    Attributes:
        value: in the effect's unit; 0: below the smallest one tried, inf: not within the sizes tried.
        interval: 90 % by bootstrap.
        cases: number of them.
        tried: smallest and largest size.
    """

    value: float
    interval: tuple[float, float]
    cases: int
    tried: tuple[float, float]


def detection_limit(
    sizes: ArrayLike, found: ArrayLike, rng: np.random.Generator, *, falls: bool = False, resamples: int = 200
) -> Limit:
    """Return the size at which a logistic curve in log |size| reaches 9 in 10.

    Args:
        sizes: true sizes, (N,).
        found: whether each was named, (N,).
        rng: of the bootstrap.
        falls: smaller values are stronger effects.
        resamples: of the bootstrap.
    """
    magnitude = np.abs(np.asarray(sizes, dtype=np.float64))
    hits = np.asarray(found, dtype=bool)
    value = _limit(magnitude, hits, falls)
    picks = rng.integers(0, magnitude.size, (resamples, magnitude.size))
    drawn = np.array([_limit(magnitude[pick], hits[pick], falls) for pick in picks])
    low, high = np.quantile(drawn, [0.05, 0.95], method="nearest")
    tried = (float(magnitude.min()), float(magnitude.max()))
    return Limit(value=value, interval=(float(low), float(high)), cases=magnitude.size, tried=tried)


def limit_without(sizes: ArrayLike, found: ArrayLike, left_out: int, *, falls: bool = False) -> float:
    """Return the value of a detection limit from all cases but one."""
    magnitude, hits = np.abs(np.asarray(sizes, dtype=np.float64)), np.asarray(found, dtype=bool)
    kept = np.arange(magnitude.size) != left_out
    if not np.any(kept):
        return 0.0 if falls else np.inf
    return _limit(magnitude[kept], hits[kept], falls)


def _limit(magnitude: Array, found: NDArray[np.bool_], falls: bool) -> float:
    """Return the limit; with `falls` the value above which the effect is lost: inf there means found at all tried."""
    never, always = (0.0, np.inf) if falls else (np.inf, 0.0)
    if np.all(found):
        return always
    if not np.any(found) or np.ptp(magnitude) == 0.0:
        return never
    x = np.log(magnitude) * (-1.0 if falls else 1.0)
    centre, width = float(np.mean(x)), float(np.std(x))
    offset, slope = _logistic((x - centre) / width, found)
    if slope <= 0.0:
        return always if np.mean(found) >= _FOUND else never
    at = (np.log(_FOUND / (1.0 - _FOUND)) - offset) / slope * width + centre
    if at > x.max():
        return never
    if at < x.min():
        return always
    return float(np.exp(-at if falls else at))


def _logistic(x: Array, found: NDArray[np.bool_]) -> tuple[float, float]:
    """Return offset and slope of the curve by penalised likelihood (Newton's method)."""
    design = np.column_stack((np.ones_like(x), x))
    weights = np.zeros(2)
    for _ in range(60):
        chance = 1.0 / (1.0 + np.exp(-np.clip(design @ weights, -30.0, 30.0)))
        gradient = design.T @ (found - chance) - _RIDGE * weights
        curvature = (design * (chance * (1.0 - chance))[:, None]).T @ design + _RIDGE * np.eye(2)
        step = np.linalg.solve(curvature, gradient)
        weights = weights + step * min(1.0, 3.0 / max(float(np.max(np.abs(step))), 1e-12))
        if np.max(np.abs(step)) < 1e-9:
            break
    return float(weights[0]), float(weights[1])


def calibration_error(probability: ArrayLike, right: ArrayLike, bins: int = 10) -> tuple[float, list[dict[str, float]]]:
    """Return (expected calibration error, its bins: mean probability, share right, count).

    Args:
        probability: of what was most probable, (N,).
        right: whether that was the truth, (N,).
        bins: number of equal bins from 0 to 1.
    """
    p, hit = np.asarray(probability, dtype=np.float64), np.asarray(right, dtype=np.float64)
    index = np.clip((p * bins).astype(int), 0, bins - 1)
    found = [
        {"mean": float(p[index == b].mean()), "right": float(hit[index == b].mean()), "count": int(np.sum(index == b))}
        for b in range(bins)
        if np.any(index == b)
    ]
    error = sum(entry["count"] * abs(entry["mean"] - entry["right"]) for entry in found) / max(p.size, 1)
    return float(error), found
