r"""Sensors whose axes are not the body's: the 24 right-handed ways to mount one at right angles, and logs read so.

With a mounting R a vector y_s of the sensor is y = R y_s in the body. What a set states of it is any turn; what it may
be beside that, unsaid, is a signed permutation with det R = 1. An attitude q that was told with the IMU's turn becomes
q * q(R)^-1. It was where its rates agree with the gyro as it was read:

    sum |omega(q) - y_s|^2 < sum |omega(q) - R y_s|^2
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.log import CHANNELS_OF, VehicleLog
from gap_diagnosis.vehicle.rules import UPRIGHT
from gap_diagnosis.vehicle.turns import attitudes_with, read_with, rotations

__all__ = ["MOUNTINGS", "imu_mounted", "named", "turned_too", "upright", "velocity_mounted"]

Array = NDArray[np.float64]
_SIGNED = [np.diag(s) @ np.eye(3)[list(p)] for p in permutations(range(3)) for s in product((1.0, -1.0), repeat=3)]
MOUNTINGS: tuple[Array, ...] = tuple(R for R in _SIGNED if np.linalg.det(R) > 0.0)
"""All R, as stated (the identity) first."""


def named(R: Array) -> tuple[str, str, str]:
    """Return which reading of the sensor is forward, starboard and down."""
    forward, starboard, down = (f"{'-' if row.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}" for row in R)
    return forward, starboard, down


def imu_mounted(log: VehicleLog, R: Array, attitude: bool) -> VehicleLog:
    """Return a log whose IMU is read as mounted by R; attitude: whether that was told with the same turn."""
    log = _read(_read(log, "gyro", R), "accelerometer", R)
    if not attitude:
        return log
    there = np.isfinite(log.attitude).all(axis=1)
    turned = log.attitude.copy()
    turned[there] = attitudes_with(turned[there], R)
    return replace(log, attitude=turned)


def velocity_mounted(log: VehicleLog, R: Array) -> VehicleLog:
    """Return a log whose velocity log is read as mounted by R."""
    return _read(log, "velocity", R)


def _read(log: VehicleLog, sensor: str, R: Array) -> VehicleLog:
    told, noise, at = log.told.copy(), log.noise.copy(), CHANNELS_OF[sensor]
    told[:, at], noise[at] = read_with(log.told[:, at], R), np.abs(read_with(log.noise[at], R))
    return replace(log, told=told, noise=noise)


def upright(logs: Sequence[VehicleLog], R: Array) -> bool:
    """Return whether a specific force read with a mounting holds a vehicle up; True where none is told."""
    force = np.concatenate([log.told[:, 6:9] for log in logs])
    force = force[np.isfinite(force).all(axis=1)]
    if not len(force):
        return True
    mean = R @ force.mean(axis=0)
    return bool(mean[2] < -UPRIGHT * 9.81)


def turned_too(logs: Sequence[VehicleLog], R: Array) -> bool:
    """Return whether the attitude was told with the same turn as the gyro of an IMU that is mounted by R."""
    as_told = as_read = 0.0
    for log in logs:
        there: NDArray[np.bool_] = np.asarray(np.isfinite(log.attitude).all(axis=1))
        pairs = np.flatnonzero(there[1:] & there[:-1])
        if not pairs.size:
            continue
        before, after = (rotations(log.attitude[pairs + j]) for j in (0, 1))
        rates = (before.inv() * after).as_rotvec() / log.period
        y = 0.5 * (log.told[pairs, 3:6] + log.told[pairs + 1, 3:6])
        as_told += float(np.nansum((rates - y) ** 2))
        as_read += float(np.nansum((rates - read_with(y, R)) ** 2))
    return as_told < as_read
