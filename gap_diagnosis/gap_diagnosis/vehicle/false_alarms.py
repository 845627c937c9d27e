r"""From a healthy vehicle's hours to a threshold for a rate of false alarms, and from peaks to that rate.

A log ratio leaves zero, climbs and falls back: an excursion. Its peak alone says at which thresholds it would have been
an alarm. Beyond a level u that TAIL excursions passed, peaks fall off as an exponential with mean excess theta, as
those of a cumulated sum do:

    rate(h) = TAIL / T exp(-(h - u) / theta),     h(rate) = u + theta ln(TAIL / (T rate))

Within the peaks that were seen the count itself stands.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

__all__ = ["Excursions", "most_alarms", "rate_at", "threshold_for"]

Array = NDArray[np.float64]
TAIL = 20
"""Excursions that the tail is fitted to: its mean excess is then known to a quarter."""


class Excursions:
    """Peaks of log ratios between two zeros, as they are seen at the end of each piece."""

    def __init__(self, names: int, least: float = 1.0) -> None:
        """Follow so many ratios; peaks below `least` are not kept."""
        self._now, self._least = np.zeros(names), least
        self.peaks: list[float] = []

    def add(self, ratios: Array) -> None:
        """Take the ratios after a piece."""
        ended = (ratios <= 0.0) & (self._now > self._least)
        self.peaks += [float(p) for p in self._now[ended]]
        self._now = np.where(ratios <= 0.0, 0.0, np.maximum(self._now, ratios))

    def close(self) -> list[float]:
        """Return all peaks, those of excursions that are still under way too."""
        return [*self.peaks, *(float(p) for p in self._now[self._now > self._least])]


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
        ValueError: too few excursions to fit a tail to.
    """
    if len(peaks) <= TAIL:
        raise ValueError(f"peaks: expected more than {TAIL} excursions; found {len(peaks)} in {hours:.2g} h")
    if rate * hours >= TAIL:
        return float(np.sort(peaks)[::-1][min(int(rate * hours), len(peaks)) - 1])
    level, excess = _tail(peaks)
    return level + excess * float(np.log(TAIL / (hours * rate)))


def most_alarms(counted: int, hours: float) -> float:
    """Return the rate per hour that so many alarms in so many hours exclude at 95 %: Poisson, by its quantile."""
    return float(chi2.ppf(0.95, 2 * (counted + 1))) / 2.0 / hours


def _tail(peaks: Sequence[float]) -> tuple[float, float]:
    highest = np.sort(peaks)[::-1][: TAIL + 1]
    return float(highest[-1]), max(float(np.mean(highest[:-1] - highest[-1])), 1e-6)
