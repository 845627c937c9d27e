"""How fast a gyro turns, over how fast the attitude of the same vehicle does.

Over a window that is short enough for turns to add up,  k = |int omega dt| / |2 log(q_0^-1 q_1)|,  1 where both are in
one unit and whichever axes both have. Of yaw alone, with the gyro's rates in the level frame of roll and pitch,

    k = Delta psi / int (q sin phi + r cos phi) / cos theta dt,      Delta psi but for whole turns.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.integrate import cumulative_trapezoid

from .axes import down_in_body
from .sources import Array

__all__ = ["heading_ratio", "turning_ratio"]

_WINDOW, _FEWEST = 0.5, 40
"""[s] Of a turn; windows below which nothing is said."""
_ALIKE = 0.9
"""Correlation of both turns from which on they are of one movement."""
_YAWED, _LEVEL = 0.02, 0.5
"""[rad] Of a window in which yaw turns; least share of the vertical along the body's z axis."""
_HALF = 0.5
"""Share of what 1 leaves, and of what no turn at all leaves, that another k may leave at most."""


def turning_ratio(gyro: tuple[Array, Array], attitude: tuple[Array, Array]) -> float | None:
    """Return k, None where the two are of no common movement.

    Args:
        gyro: times [s] and rates (N, 3) in any unit.
        attitude: times [s] and quaternions w, x, y, z (N, 4).
    """
    time, rates = gyro
    at, q = attitude
    if min(time.size, at.size) < _FEWEST:
        return None
    edges = np.arange(max(time[0], at[0]), min(time[-1], at[-1]), _WINDOW)
    if edges.size <= _FEWEST:
        return None
    turned = cumulative_trapezoid(rates, time, axis=0, initial=0.0)
    by_gyro = np.diff(_between(edges, time, turned), axis=0)
    same = np.cumprod(np.where(np.einsum("ij,ij->i", q[1:], q[:-1]) < 0.0, -1.0, 1.0))  # q and -q are one attitude
    told = _between(edges, at, q * np.concatenate(([1.0], same))[:, None])
    there = np.linalg.norm(told, axis=1) > 0.5
    by_attitude = _turn(told[:-1], told[1:])
    told_by_both = there[:-1] & there[1:] & _covered(edges, time) & _covered(edges, at)
    a, b = by_gyro[told_by_both], by_attitude[told_by_both]
    sizes = float(np.linalg.norm(a)), float(np.linalg.norm(b))
    if len(a) < _FEWEST or min(sizes) == 0.0 or float(np.sum(a * b)) < _ALIKE * sizes[0] * sizes[1]:
        return None
    return sizes[0] / sizes[1]


def heading_ratio(gyro: tuple[Array, Array], attitude: tuple[Array, Array], others: Sequence[float]) -> float | None:
    """Return k of yaw alone where it is one of `others`, None where it is 1 or nothing tells it.

    Args:
        gyro: times [s] and rates (N, 3) [rad/s].
        attitude: times [s] and quaternions w, x, y, z (N, 4) of a right roll and pitch.
    """
    time, rates = gyro
    at, q = attitude
    if min(time.size, at.size) < _FEWEST:
        return None
    _, y, z = _between(time, at, down_in_body(q)).T  # cos theta sin phi, cos theta cos phi
    level = y * y + z * z
    rate = (rates[:, 1] * y + rates[:, 2] * z) / np.maximum(level, _LEVEL**2)
    instants = at[np.searchsorted(at, np.arange(max(time[0], at[0]), min(time[-1], at[-1]), _WINDOW))]
    k = np.unique(np.searchsorted(at, instants))
    w, i, j, n = q[k].T
    heading = np.arctan2(2.0 * (i * j + w * n), 1.0 - 2.0 * (j * j + n * n))
    by_gyro = np.diff(np.interp(at[k], time, cumulative_trapezoid(rate, time, initial=0.0)))
    by_yaw = np.diff(heading)
    upright = np.interp(at[k], time, z) > _LEVEL
    used = (
        (np.abs(by_gyro) > _YAWED) & upright[1:] & upright[:-1] & _covered(at[k], time) & (np.diff(at[k]) < 2 * _WINDOW)
    )
    if used.sum() < _FEWEST:
        return None
    left = {f: float(np.median(_unwound(by_yaw[used] - f * by_gyro[used]))) for f in (0.0, 1.0, *others)}
    best = min(others, key=lambda f: left[f])
    return best if left[best] < _HALF * min(left[0.0], left[1.0]) else None


def _unwound(angles: Array) -> Array:
    """Return the size of angles [rad] but for whole turns."""
    return np.abs((angles + np.pi) % (2.0 * np.pi) - np.pi)


def _between(edges: Array, time: Array, values: Array) -> Array:
    return np.column_stack([np.interp(edges, time, column) for column in values.T])


def _covered(edges: Array, time: Array) -> Array:
    """Tell in which windows there are readings: half as many as usual, at least one."""
    count = np.diff(np.searchsorted(time, edges))
    return np.asarray(count >= max(0.5 * float(np.median(count)), 1.0))


def _turn(first: Array, second: Array) -> Array:
    """Return the turns between attitudes (N, 3) [rad], in axes of the first one."""
    w, v = first[:, :1], first[:, 1:]
    scalar = w * second[:, :1] + np.sum(v * second[:, 1:], axis=1, keepdims=True)
    vector = w * second[:, 1:] - second[:, :1] * v - np.cross(v, second[:, 1:])
    size = np.linalg.norm(vector, axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(size, np.abs(scalar))
    return np.asarray(np.sign(scalar) * vector * angle / np.maximum(size, 1e-12))
