"""Outliers of a sensor: single readings far from all that stand around them, as no vehicle moves."""

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules

__all__ = ["lone_readings"]

Array = NDArray[np.float64]
_ASIDE = 2
"""Readings to either side that one is compared with."""


def lone_readings(values: Array, noise: Array) -> NDArray[np.bool_]:
    """Return which readings (K, m), of noises (m,), stand alone in any column, (K,): none where that is no rarity.

    Around a step or a peak that a vehicle makes, neighbours differ from each other, too (Hampel's identifier with
    their spread beside the noise).
    """
    alone = np.zeros(len(values), dtype=np.bool_)
    if len(values) <= 2 * _ASIDE:
        return alone
    for column, own in zip(values.T, noise, strict=True):
        windows = np.lib.stride_tricks.sliding_window_view(column, 2 * _ASIDE + 1)
        around = np.delete(windows, _ASIDE, axis=1)
        far = rules.LONE_NOISE * own + rules.LONE_SPREAD * np.ptp(around, axis=1)
        alone[_ASIDE:-_ASIDE] |= np.abs(windows[:, _ASIDE] - np.median(around, axis=1)) > far
    return alone if np.mean(alone) < rules.LONE_MOST else np.zeros_like(alone)
