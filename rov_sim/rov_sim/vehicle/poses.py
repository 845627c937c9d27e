r"""Attitudes and positions of a recorded vehicle: arrays over time, for scores and pictures.

Attitude q = (w, x, y, z) turns body axes (x forward, y starboard, z down) into the earth's (north, east, down); Euler
angles are roll, pitch, yaw (`thruster_model.equations.attitude`). Viewers hold z for up: REP 103's earth frame is east,
north, up, its body x forward, y left, z up.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.equations import attitude

__all__ = [
    "FLU_OF_FRD", "NED_OF_ENU", "at_instants", "attitudes_at", "body_rates", "euler_angles", "rotated", "upright",
]  # fmt: skip

Array = NDArray[np.float64]

NED_OF_ENU: Array = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])
"""Turns (east, north, up) into (north, east, down); its own inverse but for its sign."""
FLU_OF_FRD: Array = np.array([0.0, 1.0, 0.0, 0.0])
"""Turns (forward, right, down) into (forward, left, up); its own inverse but for its sign."""
_INSTANT = 1e-9  # s; closer stamps are one


def _tuple(values: ArrayLike) -> tuple[Array, ...]:
    return tuple(np.moveaxis(np.asarray(values, dtype=np.float64), -1, 0))


def rotated(q: ArrayLike, vector: ArrayLike) -> Array:
    """Return vectors (..., 3) of body axes in the earth's, of attitudes q (..., 4)."""
    return np.stack(np.broadcast_arrays(*attitude.rotated(_tuple(q), _tuple(vector))), axis=-1)


def euler_angles(q: ArrayLike) -> Array:
    """Return roll, pitch, yaw [rad], (..., 3), of unit quaternions (..., 4)."""
    return np.stack(attitude.euler_from_quaternion(_tuple(q)), axis=-1)


def body_rates(angles: ArrayLike, rates: ArrayLike) -> Array:
    """Return nu_2 = J_2^-1 rates [rad/s], (..., 3), of Euler angles [rad] that change at `rates` [rad/s]."""
    inverse = attitude.euler_rate_matrix_inverse(_tuple(angles))
    return np.stack(np.broadcast_arrays(*attitude.matrix_times(inverse, _tuple(rates))), axis=-1)


def upright(position: ArrayLike, q: ArrayLike) -> tuple[Array, Array]:
    """Return position (..., 3) [m] in (east, north, up) and the attitude (..., 4) of (forward, left, up) in it.

    Args:
        position: north, east, down [m].
        q: attitude, from (forward, right, down).
    """
    north, east, down = _tuple(position)
    turned = attitude.quaternion_product(attitude.quaternion_product(_tuple(NED_OF_ENU), _tuple(q)), _tuple(FLU_OF_FRD))
    sign = np.where(turned[0] < 0.0, -1.0, 1.0)
    return np.stack([east, north, -down], axis=-1), np.stack([sign * part for part in turned], axis=-1)


def at_instants(instants: ArrayLike, time: ArrayLike, values: ArrayLike) -> Array:
    """Return values (N,) or (N, k), taken on at `time` (N,) [s], at other instants (M,): lines between, NaN outside.

    Where an instant is one of `time`, the value is that one.
    """
    wanted, t = np.asarray(instants, dtype=np.float64), np.asarray(time, dtype=np.float64)
    v = np.asarray(values, dtype=np.float64)
    columns = v.reshape(t.size, -1)
    shape = (wanted.size, *v.shape[1:])
    if t.size == 0:
        return np.full(shape, np.nan)
    outside = (wanted < t[0] - _INSTANT) | (wanted > t[-1] + _INSTANT)
    found = np.column_stack([np.interp(wanted, t, column) for column in columns.T])
    found[outside] = np.nan
    return np.asarray(found.reshape(shape))


def attitudes_at(instants: ArrayLike, time: ArrayLike, attitudes: ArrayLike) -> Array:
    """Return attitudes (N, 4) at other instants, (M, 4): the normalised line between neighbours, NaN outside."""
    q = np.array(attitudes, dtype=np.float64)
    turns = np.where(np.einsum("ij,ij->i", q[1:], q[:-1]) < 0.0, -1.0, 1.0)  # q and -q are one attitude
    q[1:] *= np.cumprod(turns)[:, None]
    found = at_instants(instants, time, q)
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))
