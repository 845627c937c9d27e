r"""From a healthy vehicle's hours to a threshold for a rate of false alarms, and from peaks to that rate.

The highest log ratio of all failures in each minute says at which thresholds that minute would have held an alarm:
failures that rise together are one. Beyond a level u that TAIL of these peaks passed, they fall off as an exponential
with mean excess theta, as those of a cumulated sum do:

    rate(h) = TAIL / T exp(-(h - u) / theta),     h(rate) = u + theta ln(TAIL / (T rate))

Within the peaks that were seen the count itself stands.

An alarm's probability follows from both rates, of failures and of false alarms at the highest log ratio g_1, and from
how far behind other failures are. A log ratio that is larger by theta is e times as sure, as the tail tells, and not
exp(theta) times, as it would be if the model were right:

    p_j = f w_j / (f sum_i w_i + rate(g_1)),     w_i = exp((g_i - g_1) / theta)
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

__all__ = ["excess", "most_alarms", "probabilities", "rate_at", "stated_rate", "threshold_for"]

Array = NDArray[np.float64]
TAIL = 20
"""Peaks that the tail is fitted to: its mean excess is then known to a quarter."""
COUNTED_HOURS, COUNTED = 173.0, ((20.0, 58), (35.0, 24), (45.0, 16))
"""[h] of 88 healthy vehicles (seeds 2016 to 2060, 2063 to 2105) that `watch_rate` counted, and in how many minutes a
threshold was reached, the lowest first."""
FAILURES = 0.1
"""[1/h] of failures that are expected of a vehicle: as many as the false alarms that are accepted."""


def rate_at(threshold: float, peaks: Sequence[float], hours: float) -> float:
    """Return false alarms per hour at a threshold: as counted, beyond the largest peaks by the tail."""
    beyond = sum(p >= threshold for p in peaks)
    if beyond >= TAIL or len(peaks) <= TAIL:
        return beyond / hours
    level, excess = _tail(peaks)
    return TAIL / hours * float(np.exp(-max(threshold - level, 0.0) / excess))


def threshold_for(rate: float, peaks: Sequence[float], hours: float) -> float:
    """Return the threshold at which there is this rate of false alarms per hour.

    Raises:
        ValueError: too few peaks to fit a tail to.
    """
    if len(peaks) <= TAIL:
        raise ValueError(f"expected more than {TAIL} minutes; found {len(peaks)} in {hours:.2g} h")
    if rate * hours >= TAIL:
        return float(np.sort(peaks)[::-1][min(int(rate * hours), len(peaks)) - 1])
    level, excess = _tail(peaks)
    return level + excess * float(np.log(TAIL / (hours * rate)))


def excess() -> float:
    """Return theta, the mean excess of the exponential through the lowest and the highest threshold reached."""
    (low, more), *_, (high, fewer) = _reached()
    return (high - low) / float(np.log(more / fewer))


def _reached() -> list[tuple[float, int]]:
    return [(level, counted) for level, counted in COUNTED if counted]


def _counted_rate(threshold: float) -> float:
    lowest, *higher = _reached()
    level, counted = max((each for each in higher if each[0] <= threshold), default=lowest)
    return counted / COUNTED_HOURS * float(np.exp((level - threshold) / excess()))


def stated_rate(threshold: float) -> str:
    """Return false alarms per hour at a threshold, in words: what was counted, and what that excludes at 95 %."""
    within = [counted for level, counted in COUNTED if threshold >= level]
    if not within:
        return f"not counted below a threshold of {COUNTED[0][0]:g}"
    most = most_alarms(within[-1], COUNTED_HOURS)
    return f"{_counted_rate(threshold):.1g} (less than {most:.2g} at 95 %, {COUNTED_HOURS:g} h counted)"


def probabilities(log_ratios: Sequence[float]) -> Array:
    """Return of each failure, one log ratio each, how probable it is that it is the one and no false alarm."""
    ratios = np.asarray(log_ratios, dtype=np.float64)
    weights = np.exp((ratios - ratios.max()) / excess())
    return np.asarray(FAILURES * weights / (FAILURES * weights.sum() + _counted_rate(float(ratios.max()))))


def most_alarms(counted: int, hours: float) -> float:
    """Return the rate per hour that so many alarms in so many hours exclude at 95 %: Poisson, by its quantile."""
    return float(chi2.ppf(0.95, 2 * (counted + 1))) / 2.0 / hours


def _tail(peaks: Sequence[float]) -> tuple[float, float]:
    highest = np.sort(peaks)[::-1][: TAIL + 1]
    return float(highest[-1]), max(float(np.mean(highest[:-1] - highest[-1])), 1e-6)
