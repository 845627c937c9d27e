r"""What a viewer draws of a vehicle: its frames, the path behind it, an arrow for each thruster.

Frames, each with one parent, so that either kind of axes is there:

    map (east, north, up)  ->  base_link (forward, left, up)  ->  base_link_frd (forward, right, down)
                           ->  map_ned (north, east, down)

The first two are REP 103's: viewers hold z for up, and show the vehicle the right way round in them. The turn from
map_ned to base_link_frd is the attitude of rov/odometry.
"""

from collections.abc import Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rov_sim.vehicle.poses import FLU_OF_FRD, NED_OF_ENU, upright

__all__ = [
    "AT_LIMIT", "BASE", "BASE_FRD", "MAP", "MAP_NED", "NEAR", "WANTED", "WITHIN", "Arrow", "Colour", "Layout",
    "PathMemory", "Transform", "arrows", "transforms",
]  # fmt: skip

Array = NDArray[np.float64]

MAP, MAP_NED, BASE, BASE_FRD = "map", "map_ned", "base_link", "base_link_frd"
_NEAR = 0.8  # of a limit, from which an arrow warns
_NO_ARROW = 0.02  # N; less is not drawn


class Colour(NamedTuple):
    """Red, green, blue, opacity, each from 0 to 1."""

    red: float
    green: float
    blue: float
    opacity: float = 1.0


WITHIN, NEAR, AT_LIMIT = Colour(0.0, 0.51, 0.37), Colour(0.9, 0.62, 0.0), Colour(0.84, 0.15, 0.12)
WANTED = Colour(0.6, 0.65, 0.7, 0.5)


class Transform(NamedTuple):
    """Where a child frame is in its parent: translation [m], rotation (w, x, y, z) from the child's axes."""

    parent: str
    child: str
    translation: Array
    rotation: Array


class Layout(NamedTuple):
    """Where the thrusters are in body axes [m], and their directions of forward thrust, (N, 3) each."""

    positions: Array
    axes: Array


class Arrow(NamedTuple):
    """From start to end in body axes (forward, right, down) [m]."""

    thruster: int
    start: Array
    end: Array
    colour: Colour


def transforms(position: ArrayLike, attitude: ArrayLike, *, rep_103: bool = True) -> list[Transform]:
    """Return the tree of frames of a vehicle at a position (north, east, down) [m] with an attitude (w, x, y, z).

    Args:
        position, attitude: as rov/odometry gives them.
        rep_103: with the frames whose z is up; else map_ned is the root and base_link_frd its child.
    """
    if not rep_103:
        return [Transform(MAP_NED, BASE_FRD, np.asarray(position, np.float64), np.asarray(attitude, np.float64))]
    place, turn = upright(position, attitude)
    none = np.zeros(3)
    return [
        Transform(MAP, BASE, place, turn),
        Transform(MAP, MAP_NED, none, NED_OF_ENU),
        Transform(BASE, BASE_FRD, none, FLU_OF_FRD),
    ]


def arrows(
    layout: Layout,
    thrusts: Sequence[float],
    *,
    length: float,
    limits: tuple[float, float],
    colour: Colour | None = None,
) -> list[Arrow]:
    """Return an arrow for each thruster that pushes: along its force on the vehicle, as long as the thrust is large.

    Args:
        layout: of N thrusters.
        thrusts: N [N], positive along the axis; NaN: unknown, not drawn.
        length: of an arrow per thrust [m/N].
        limits: largest reverse and forward thrust [N], both positive; they give the colour.
        colour: of all arrows instead.
    """
    found = []
    for k, T in enumerate(thrusts):
        if not isfinite(T) or abs(T) < _NO_ARROW:
            continue
        share = abs(T) / limits[1 if T > 0.0 else 0]
        own = AT_LIMIT if share >= 1.0 else NEAR if share >= _NEAR else WITHIN
        axis = layout.axes[k] / np.linalg.norm(layout.axes[k])
        start = layout.positions[k]
        found.append(Arrow(k, start, start + length * T * axis, own if colour is None else colour))
    return found


class PathMemory:
    """The path behind a vehicle, in a bounded number of points.

    A point is kept when it is `spacing` [m] from the last one; when there are too many, every other one goes and the
    spacing doubles.
    """

    def __init__(self, spacing: float, most: int) -> None:
        """Begin without a point; `most` >= 2."""
        self.spacing, self.most = spacing, most
        self.kept: list[tuple[int, Array, Array]] = []

    def add(self, stamp: int, position: Array, attitude: Array) -> None:
        """Take a pose; one that is before the last begins the path anew."""
        if self.kept and stamp < self.kept[-1][0]:
            self.kept.clear()
        if self.kept and np.linalg.norm(position - self.kept[-1][1]) < self.spacing:
            return
        self.kept.append((stamp, position, attitude))
        if len(self.kept) > self.most:
            self.kept = self.kept[::2]
            self.spacing *= 2.0
