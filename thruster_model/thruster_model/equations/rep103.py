r"""REP 103's primary frames: earth east, north, up (`map`), body forward, left, up (`base_link`).

Everything else here is in the secondary ones: earth north, east, down (`map_ned`), body forward, starboard, down
(`base_link_frd`). The turn between either pair is its own inverse:

(east, north, up) = (y, x, -z) of the earth,     (forward, left, up) = (x, -y, -z) of the body
"""

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.equations.attitude import quaternion_product

__all__ = ["in_body_flu", "in_map", "pose_covariance_in_map", "turned_attitude", "velocity_covariance_in_body_flu"]

Array = NDArray[np.float64]

_EARTH: Array = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
_BODY: Array = np.diag([1.0, -1.0, -1.0])
_OF_EARTH = (0.0, sqrt(0.5), sqrt(0.5), 0.0)
_OF_BODY = (0.0, 1.0, 0.0, 0.0)


def in_map(position: ArrayLike) -> Array:
    """Return a vector (3,) of (north, east, down) as (east, north, up)."""
    return _EARTH @ np.asarray(position, dtype=np.float64)


def in_body_flu(velocity: ArrayLike) -> Array:
    """Return nu (6,) in body axes forward, left, up."""
    return np.concatenate([_BODY @ part for part in np.split(np.asarray(velocity, dtype=np.float64), 2)])


def turned_attitude(attitude: ArrayLike) -> tuple[float, float, float, float]:
    """Return the quaternion (w, x, y, z) of `base_link` in `map` for that of `base_link_frd` in `map_ned`."""
    w, x, y, z = np.asarray(attitude, dtype=np.float64).tolist()
    turned = quaternion_product(quaternion_product(_OF_EARTH, (w, x, y, z)), _OF_BODY)
    sign = -1.0 if turned[0] < 0.0 else 1.0
    return sign * turned[0], sign * turned[1], sign * turned[2], sign * turned[3]


def pose_covariance_in_map(covariance: ArrayLike) -> Array:
    """Return the covariance (6, 6) of position and turns about the earth's axes in the axes of `map`."""
    return _both(_EARTH, covariance)


def velocity_covariance_in_body_flu(covariance: ArrayLike) -> Array:
    """Return the covariance (6, 6) of nu in the axes of `base_link`."""
    return _both(_BODY, covariance)


def _both(turn: Array, covariance: ArrayLike) -> Array:
    whole = np.kron(np.eye(2), turn)
    return np.asarray(whole @ np.asarray(covariance, dtype=np.float64).reshape(6, 6) @ whole.T)
