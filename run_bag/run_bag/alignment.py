"""Bring samples at their own stamps onto a common grid.

Stamps and grid are integer nanoseconds, so that a grid point on a stamp is on it, not beside it by rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Method = Literal["previous", "linear", "mean"]
Stamps = NDArray[np.int64]
Values = NDArray[np.float64]
HOLDS = ("previous", "linear")
"""What a signal may do between its samples."""
DENSE = 3e-3
"""Period of a thruster's commands [s] up to which it makes no difference whether they are held or lines in between."""


def moves_between(time: Values, commands: Values) -> bool:
    """Tell whether it matters how commands [V] at `time` [s] act between their samples: these are rare, and change."""
    changes = np.diff(commands[np.isfinite(commands)]) != 0.0
    return time.size > 2 and float(np.median(np.diff(time))) > DENSE and bool(np.any(changes))


def _outside(stamps: Stamps, grid: Stamps) -> NDArray[np.bool_]:
    return (grid < stamps[0]) | (grid > stamps[-1])


def previous(stamps: Stamps, values: Values, grid: Stamps) -> Values:
    """Hold the last sample at or before each grid point (of several with one stamp, the last)."""
    index = np.searchsorted(stamps, grid, side="right") - 1
    return np.where(_outside(stamps, grid), np.nan, values[np.maximum(index, 0)])


def linear(stamps: Stamps, values: Values, grid: Stamps) -> Values:
    """Interpolate between neighbouring samples; a NaN neighbour gives NaN."""
    last = np.append(stamps[1:] != stamps[:-1], True)
    ticks, kept, origin = stamps[last], values[last], stamps[0]
    right = np.clip(np.searchsorted(ticks, grid, side="left"), 0, len(ticks) - 1)
    left = np.where(ticks[right] == grid, right, np.maximum(right - 1, 0))
    span = np.maximum(ticks[right] - ticks[left], 1)
    weight = ((grid - origin) - (ticks[left] - origin)) / span
    result = np.where(left == right, kept[left], (1 - weight) * kept[left] + weight * kept[right])
    return np.where(_outside(stamps, grid), np.nan, result)


def mean(stamps: Stamps, values: Values, grid: Stamps) -> Values:
    """Average the measured samples in the half-open cell around each grid point, borders half-way between."""
    steps = np.diff(grid)
    middles = grid[:-1] + steps // 2
    borders = np.concatenate([[grid[0] - steps[0] // 2], middles, [grid[-1] + (steps[-1] + 1) // 2]])
    measured = np.isfinite(values)
    edges = np.searchsorted(stamps[measured], borders, side="left")
    offset = float(np.mean(values[measured])) if measured.any() else 0.0  # keeps the running sum small
    total = np.concatenate([[0.0], np.cumsum(values[measured] - offset)])
    count = np.diff(edges)
    with np.errstate(invalid="ignore", divide="ignore"):
        result = (total[edges[1:]] - total[edges[:-1]]) / count + offset
    return np.where((count == 0) | _outside(stamps, grid), np.nan, result)


ALIGNMENTS: dict[str, Callable[[Stamps, Values, Stamps], Values]] = {
    "previous": previous,
    "linear": linear,
    "mean": mean,
}
