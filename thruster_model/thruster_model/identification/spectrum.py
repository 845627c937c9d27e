"""Spectrum of residuals with gaps."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

__all__ = ["amplitude_density"]

Array = NDArray[np.float64]


def amplitude_density(series: Sequence[Array], rate: float, *, segment: int = 128) -> tuple[Array, Array]:
    """Return (frequencies [Hz], amplitude density [unit/sqrt(Hz)]) averaged over all gapless stretches.

    Args:
        series: evenly spaced samples with NaN in gaps.
        rate: of the samples [Hz].
        segment: length of a stretch in samples; shorter stretches are left out. Both are empty if none is left.
    """
    densities, weights = [], []
    frequencies = np.empty(0)
    for values in series:
        known = np.isfinite(values)
        edges = np.flatnonzero(np.diff(np.concatenate(([0], known.astype(np.int8), [0]))))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            if last - first >= segment:
                frequencies, density = welch(values[first:last], fs=rate, nperseg=segment, detrend="constant")
                densities.append(density)
                weights.append(last - first)
    if not densities:
        return np.empty(0), np.empty(0)
    return frequencies[1:], np.sqrt(np.average(densities, axis=0, weights=weights))[1:]
