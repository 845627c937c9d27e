"""The axes of a vehicle by name, one and in pairs such as `surge-pitch`."""

import numpy as np
from numpy.typing import NDArray

from thruster_model.vehicle_parameters import AXIS_NAMES

__all__ = ["AXIS_PAIRS", "BODY_AXES", "axis_index", "axis_pair", "coupled", "pushed_by"]

BODY_AXES = AXIS_NAMES
REACH = 0.3
"""Share of a thruster's axis along surge, sway or heave from which on its wake may meet the hull on that axis."""
AXIS_PAIRS = tuple(f"{a}-{b}" for a in BODY_AXES for b in BODY_AXES if a != b)


def axis_index(axis: str) -> int:
    """Return the place of an axis in nu."""
    return BODY_AXES.index(axis)


def axis_pair(axes: str) -> tuple[int, int]:
    """Return the places of two axes in nu."""
    first, second = axes.split("-")
    return axis_index(first), axis_index(second)


def coupled(matrix: NDArray[np.float64], axes: str, size: float) -> NDArray[np.float64]:
    """Return a matrix (6, 6) with so much more in both entries of two axes."""
    (a, b), out = axis_pair(axes), matrix.copy()
    out[a, b] += size
    out[b, a] += size
    return out


def pushed_by(configuration: NDArray[np.float64], thruster: int) -> list[str]:
    """Return the axes along which the wake of a thruster may meet the hull; configuration: K_t, (6, N)."""
    return [BODY_AXES[int(k)] for k in np.flatnonzero(np.abs(configuration[:3, thruster]) > REACH)]
