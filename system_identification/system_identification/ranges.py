"""Steps of a fit whose unknowns have ranges."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["within_ranges"]

Array = NDArray[np.float64]


def within_ranges(
    bounded: Callable[[Array], Array], x: Array, step: Array, information: Array, gradient: Array
) -> Array:  # fmt: skip
    """Return where a step leads inside the ranges: cut at the end of one, the others are re-tuned to what is left.

    Args:
        bounded: puts unknowns within their ranges.
        x: unknowns, (K,).
        step: of Gauss and Newton from there, (K,).
        information: J^T J and inverse variances, (K, K); gradient: upwards of the log likelihood, (K,).
    """
    there = bounded(x + step)
    cut = there != x + step
    if np.any(cut) and not np.all(cut):
        moved = there - x
        rest = gradient[~cut] - information[np.ix_(~cut, cut)] @ moved[cut]
        moved[~cut] = np.linalg.solve(information[np.ix_(~cut, ~cut)], rest)
        there = bounded(x + moved)
    return there
