"""Random numbers for effects that scatter: the k-th one of a seed, by a function that remembers nothing.

A live run and a prediction of it draw the same, whatever else is drawn and in whatever pieces the run is advanced.
"""

import numpy as np

from thruster_model.compilation import compiled, equation

__all__ = ["normal", "uniform"]

_STEP = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@compiled
def uniform(seed, k):  # type: ignore[no-untyped-def]
    """Return the k-th number of a seed, from 0 to below 1 (splitmix64); both whole numbers from 0 to 2^53."""
    return float(_mixed(_mixed(np.uint64(seed)) + np.uint64(k) * _STEP) >> _11) / 9007199254740992.0


@compiled
def _mixed(z):  # type: ignore[no-untyped-def]
    z = (z + _STEP) & np.uint64(0xFFFFFFFFFFFFFFFF)
    z = (z ^ (z >> _30)) * _FIRST
    z = (z ^ (z >> _27)) * _SECOND
    return z ^ (z >> _31)


@equation
def normal(first, second):  # type: ignore[no-untyped-def]
    """Return a normally distributed number of mean 0 and variance 1 from two uniform ones (Box and Muller)."""
    return np.sqrt(-2.0 * np.log(1.0 - first)) * np.cos(2.0 * np.pi * second)
