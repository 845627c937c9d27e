r"""An IMU whose axes are not the body's: the 24 right-handed ways to mount it at right angles, and logs read so.

A mounting R is a signed permutation with det R = 1; a vector y_s of the sensor is y = R y_s in the body. An attitude q
that was told with the same turn becomes q * q(R)^-1. It was where its rates agree with the gyro as it was read:

    sum |omega(q) - y_s|^2 < sum |omega(q) - R y_s|^2
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.oddities import Oddity
from gap_diagnosis.vehicle.rules import TURNED_BY, UPRIGHT

__all__ = ["MOUNTINGS", "mounted", "named", "read_with", "upright"]

Array = NDArray[np.float64]
_SIGNED = [np.diag(s) @ np.eye(3)[list(p)] for p in permutations(range(3)) for s in product((1.0, -1.0), repeat=3)]
MOUNTINGS: tuple[Array, ...] = tuple(R for R in _SIGNED if np.linalg.det(R) > 0.0)
"""All R, as stated (the identity) first."""


def named(R: Array) -> tuple[str, str, str]:
    """Return which reading of the sensor is forward, starboard and down."""
    forward, starboard, down = (f"{'-' if row.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in R)
    return forward, starboard, down


def mounted(log: VehicleLog, R: Array, log_odds: float) -> VehicleLog:
    """Return a log whose IMU is read as mounted by R, and that it shows this; log_odds: how surely."""
    told, noise = log.told.copy(), log.noise.copy()
    for at in (slice(3, 6), slice(6, 9)):
        told[:, at] = read_with(log.told[:, at], R)
        noise[at] = np.abs(read_with(log.noise[at], R))
    attitude = log.attitude
    if _turned_too(log, R):
        there = np.isfinite(attitude).all(axis=1)
        attitude = attitude.copy()
        attitude[there] = (_rotations(attitude[there]) * Rotation.from_matrix(R).inv()).as_quat()[:, [3, 0, 1, 2]]
    angle = float(Rotation.from_matrix(R).magnitude())
    shown = Oddity("imu_misalignment", "imu", None, angle, TURNED_BY, log_odds)
    return replace(log, told=told, noise=noise, attitude=attitude, oddities=(*log.oddities, shown))


def upright(logs: Sequence[VehicleLog], R: Array) -> bool:
    """Return whether a specific force read with a mounting holds a vehicle up; True where none is told."""
    force = np.concatenate([log.told[:, 6:9] for log in logs])
    force = force[np.isfinite(force).all(axis=1)]
    if not len(force):
        return True
    mean = R @ force.mean(axis=0)
    return bool(mean[2] < -UPRIGHT * 9.81)


def read_with(y: Array, R: Array) -> Array:
    """Return vectors (..., 3) of the sensor in the body's axes; what is not told of one axis takes no other with it."""
    rows = np.argmax(np.abs(R), axis=1)
    return np.asarray(y[..., rows] * R[np.arange(3), rows])


def _turned_too(log: VehicleLog, R: Array) -> bool:
    """Return whether the attitude was told with the same turn as the gyro."""
    there: NDArray[np.bool_] = np.asarray(np.isfinite(log.attitude).all(axis=1))
    pairs = np.flatnonzero(there[1:] & there[:-1])
    if not pairs.size:
        return False
    before, after = (_rotations(log.attitude[pairs + j]) for j in (0, 1))
    rates = (before.inv() * after).as_rotvec() / log.period
    y = 0.5 * (log.told[pairs, 3:6] + log.told[pairs + 1, 3:6])
    return bool(np.nansum((rates - y) ** 2) < np.nansum((rates - read_with(y, R)) ** 2))


def _rotations(q: Array) -> Rotation:
    """Return attitudes (K, 4), (w, x, y, z)."""
    return Rotation.from_quat(q[:, [1, 2, 3, 0]])
