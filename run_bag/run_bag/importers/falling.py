"""Whether a velocity is told in our axes or in REP 103's, by how the depth changes.

With q the attitude, d = (d_x, d_y, d_z) the earth's down in body axes and (u, v, w) what a topic tells of velocity,

    depth(t + 1 s) - depth(t) - int d_x u dt  =  s int (d_y v + d_z w) dt        s: 1 in our axes, -1 in REP 103's
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.integrate import cumulative_trapezoid

from ..topic import Topic
from .axes import PARTS, down_in_body
from .sources import Array
from .vectors import vector_of

__all__ = ["falling"]

_WINDOW, _FEWEST = 1.0, 20
"""[s] Over which a depth changes by more than its noise; windows below which nothing is said."""
_MOVED = 0.02
"""[m] Root mean square of the changes below which they are noise."""
_UPRIGHT = 0.5
"""Share of gravity along the attitude's z, as a rule, from which on it is taken for the vehicle's."""
_ALIKE = 0.7
"""Correlation of both sides from which on it tells s: noise reaches it in a thousandth of twenty windows."""


def falling(read: Mapping[str, Topic], topic: str) -> int:
    """Return s of a topic that tells a velocity, 0 where the depth does not tell it."""
    velocity = vector_of(read.get(topic), "twist.twist.linear", "xyz")
    depth = vector_of(read.get("rov/depth"), "depth", ("",))
    if velocity is None or depth is None or np.median(depth[1]) < 0.0:  # positive up: no depth
        return 0
    time, (u, v, w) = velocity[0], velocity[1].T
    down = _down(vector_of(read.get("rov/imu"), "orientation", PARTS), time)
    edges = np.arange(max(time[0], depth[0][0]), min(time[-1], depth[0][-1]), _WINDOW)
    if edges.size <= _FEWEST:
        return 0
    fallen, along, across = (
        np.diff(np.interp(edges, *each))
        for each in ((depth[0], depth[1][:, 0]), _summed(time, down[0] * u), _summed(time, down[1] * v + down[2] * w))
    )
    left = fallen - along
    size = float(np.linalg.norm(left) * np.linalg.norm(across))
    alike = float(left @ across) / size if size > 0.0 else 0.0
    moved = float(np.sqrt(np.mean(left**2))) > _MOVED
    return int(np.sign(alike)) if moved and abs(alike) > _ALIKE else 0


def _down(attitude: tuple[Array, Array] | None, time: Array) -> Array:
    """Return the earth's down in body axes (3, N) at these times; that of a level vehicle without an attitude, or with
    that of an IMU which is mounted upside down or on its side."""
    level = np.tile([[0.0], [0.0], [1.0]], time.size)
    if attitude is None:
        return level
    down = np.stack([np.interp(time, attitude[0], row) for row in down_in_body(attitude[1]).T])
    return down if np.median(down[2]) > _UPRIGHT else level


def _summed(time: Array, rate: Array) -> tuple[Array, Array]:
    """Return times and the integral of a rate up to each."""
    return time, np.asarray(cumulative_trapezoid(rate, time, initial=0.0))
