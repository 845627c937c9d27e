"""The path of a recorded vehicle in space, with its attitude along it."""

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.poses import rotated
from rov_sim.vehicle.recording_io import Motion, VehicleRecording
from run_bag.report import Axis, Plot, Track, needles, space

__all__ = ["path_plot"]

Array = NDArray[np.float64]

_NEEDLES = 24
_SHARE = 0.06  # length of a needle over the path's extent
_SHORTEST = 0.1  # m
FORWARD, UPPER = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])


def path_plot(recording: VehicleRecording) -> Plot:
    """Return the path with needles along the forward and the upper axis of the body."""
    motion = recording.motion
    tracks = []
    if recording.truth is not None and recording.odometry is not None:
        tracks.append(_track("odometry", recording.odometry, "data"))
    tracks.append(_track("truth" if recording.truth is not None else "odometry", motion, "fit"))
    known = np.flatnonzero(np.isfinite(motion.position).all(axis=1) & np.isfinite(motion.attitude).all(axis=1))
    if known.size:
        place = motion.position[known]
        length = max(_SHORTEST, _SHARE * float(np.max(np.ptp(place, axis=0))))
        chosen = known[np.unique(np.linspace(0, known.size - 1, min(_NEEDLES, known.size)).astype(int))]
        start, turn = motion.position[chosen], motion.attitude[chosen]
        for k, (name, axis, share) in enumerate((("forward", FORWARD, 1.0), ("upper side", UPPER, 0.6)), start=1):
            end = start + share * length * rotated(turn, np.broadcast_to(axis, start.shape))
            tracks.append(needles(name, _drawn(start), _drawn(end), color=k))
    east, north, depth = (Axis(name=name, unit="m") for name in ("east", "north", "depth"))
    return space(tracks, x=east, y=north, z=depth, z_down=True, height=520)


def _drawn(place: Array) -> Array:
    """Return north, east, down as east, north, depth, (N, 3)."""
    return place[:, [1, 0, 2]]


def _track(name: str, motion: Motion, role: str) -> Track:
    x, y, z = _drawn(motion.position).T
    return Track(name=name, x=x, y=y, z=z, role="data" if role == "data" else "fit", color=0)
