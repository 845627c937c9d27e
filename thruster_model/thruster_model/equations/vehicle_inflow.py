r"""Ambient flow at the thrusters of a vehicle.

(4.20), (4.21)   U = K_t^T (nu - nu_c)                     [m/s], one entry per thruster

with nu = [u v w p q r] the body's velocity [m/s, rad/s], nu_c that of the water in body axes, and K_t (6, N) the
thruster configuration: column i is [e_i; r_i x e_i], the wrench of one newton along the axis e_i at the position r_i
[m]. The same matrix gives the body wrench tau = K_t T; that its transpose gives the inflow is the principle of
virtual power. U is positive where the thruster advances in the direction of its forward thrust.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["inflow_at_thrusters", "thruster_configuration"]

Array = NDArray[np.float64]


def thruster_configuration(positions: ArrayLike, axes: ArrayLike) -> Array:
    """Return K_t (6, N).

    Args:
        positions: r_i in body axes [m], shape (N, 3).
        axes: directions of forward thrust in body axes, shape (N, 3); any length but zero, normalised here.
    """
    r, e = np.asarray(positions, dtype=np.float64), np.asarray(axes, dtype=np.float64)
    if r.ndim != 2 or r.shape[1] != 3 or r.shape != e.shape:
        raise ValueError(f"expected positions and axes of one shape (N, 3); got {r.shape} and {e.shape}")
    lengths = np.linalg.norm(e, axis=1, keepdims=True)
    if not (np.all(np.isfinite(r)) and np.all(np.isfinite(e)) and np.all(lengths > 0)):
        raise ValueError("expected finite positions and axes of non-zero length")
    e = e / lengths
    return np.concatenate((e, np.cross(r, e)), axis=1).T


def inflow_at_thrusters(configuration: ArrayLike, velocity: ArrayLike, current: ArrayLike = 0.0) -> Array:
    """Return U [m/s] of (4.20), (4.21), shape (..., N).

    Args:
        configuration: K_t, shape (6, N).
        velocity: nu, shape (..., 6) [m/s, rad/s].
        current: nu_c, velocity of the water in body axes, broadcastable to `velocity`.
    """
    relative = np.asarray(velocity, dtype=np.float64) - np.asarray(current, dtype=np.float64)
    return np.asarray(relative @ np.asarray(configuration, dtype=np.float64))
