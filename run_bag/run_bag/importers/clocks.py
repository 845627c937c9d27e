"""Bring two clocks together by a signal that both recorded."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from .signals import smooth

Array = NDArray[np.float64]
COARSE = 0.01  # [s]
BLOCKS = 5


def match(time: Array, values: Array, other_time: Array, other_values: Array) -> tuple[float, float, float]:
    """Find the offset that puts the other recording onto the first one's clock.

    The cost is the mean absolute difference, which a few glitches do not move; a grid search is refined below
    a sample.

    Args:
        time, values: the dense recording [s], (N,).
        other_time, other_values: the sparse recording [s], (M,), M < N, shorter than the first.

    Returns:
        offset [s] (other time 0 on the first clock), its standard deviation [s] (scatter of the offsets of
        five parts of the recording, as of their mean), and the mean absolute difference left.
    """
    calm = smooth(values, time, 0.005)

    def cost(offset: float, part: slice = slice(None)) -> float:
        at = other_time[part] + offset
        inside = (at >= time[0]) & (at <= time[-1])
        difference = np.abs(np.interp(at, time, calm) - other_values[part])
        return float(np.mean(np.where(inside, difference, np.abs(other_values[part]) + 10.0)))

    def refine(centre: float, reach: float, part: slice = slice(None)) -> float:
        grid = np.arange(centre - reach, centre + reach, COARSE / 5)
        best = float(grid[int(np.argmin([cost(g, part) for g in grid]))])
        found = minimize_scalar(
            lambda g: cost(g, part),
            bounds=(best - COARSE, best + COARSE),
            method="bounded",
            options={"xatol": 1e-5},
        )
        return float(found.x)

    grid = np.arange(time[0] - other_time[0], time[-1] - other_time[-1] + COARSE, COARSE)
    coarse = float(grid[int(np.argmin([cost(g) for g in grid]))])
    offset = refine(coarse, 0.02)
    edges = np.linspace(0, len(other_time), BLOCKS + 1).astype(int)
    parts = [refine(offset, 0.06, slice(a, b)) for a, b in pairwise(edges)]
    deviation = float(np.std(parts, ddof=1) / np.sqrt(BLOCKS))
    return offset, deviation, cost(offset)
