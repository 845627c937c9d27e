"""What the navigation filter believes about a vehicle's motion, what it was told, and what both are worth."""

from enum import IntFlag
from math import isfinite, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_estimation.belief import Level

__all__ = [
    "ERRORS", "Heard", "NavigationBelief", "NavigationInnovation", "NavigationSettings", "NavigationStatus",
    "checked_navigation", "navigation_level", "navigation_reason",
]  # fmt: skip

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

ERRORS = 15
"""Errors of the belief, in this order, three each: position [m] and velocity [m/s] of the IMU in the earth frame,
attitude [rad] about the earth's axes, bias of gyro [rad/s] and of specific force [m/s^2] in the axes of the IMU."""


class NavigationStatus(IntFlag):
    """What the last step did, and what limits the estimate."""

    INITIAL = 0
    USED_ATTITUDE = 1
    USED_VELOCITY = 2
    USED_DEPTH = 4
    GATED_ATTITUDE = 8
    GATED_VELOCITY = 16
    GATED_DEPTH = 32
    REOPENED = 64
    STALE_ATTITUDE = 128
    STALE_VELOCITY = 256
    STALE_DEPTH = 512
    NO_RATES = 1024
    BAD_PERIOD = 2048
    RESTARTED = 4096
    PREDICTED = 8192


_WORDS = {
    NavigationStatus.GATED_ATTITUDE: "the attitude measured is too unlikely and was refused",
    NavigationStatus.GATED_VELOCITY: "the velocity measured is too unlikely and was refused",
    NavigationStatus.GATED_DEPTH: "the depth measured is too unlikely and was refused",
    NavigationStatus.REOPENED: "a measurement refused for long was used after the covariance had been widened",
    NavigationStatus.STALE_ATTITUDE: "no attitude for too long: it follows from the gyro, heading drifts",
    NavigationStatus.STALE_VELOCITY: "no velocity log for too long: velocity is integrated specific force and drifts",
    NavigationStatus.STALE_DEPTH: "no depth for too long: depth is integrated velocity and drifts",
    NavigationStatus.NO_RATES: "no angular velocity or specific force: the last ones were held",
    NavigationStatus.BAD_PERIOD: "the period was no finite time >= 0: nothing was predicted",
    NavigationStatus.RESTARTED: "the estimate left the numbers and was started again with the largest deviations",
}
_INVALID = NavigationStatus.RESTARTED | NavigationStatus.BAD_PERIOD


class Heard(NamedTuple):
    """What the sensors told of one instant; NaN: nothing.

    Attributes:
        w, x, y, z: attitude of the IMU's axes in the earth frame (north, east, down), a unit quaternion.
        rate_x, rate_y, rate_z: angular velocity in the axes of the IMU [rad/s].
        force_x, force_y, force_z: specific force there [m/s^2].
        velocity_x, velocity_y, velocity_z: of the velocity log over ground, in its axes [m/s].
        depth: of the depth sensor [m].
    """

    w: float = nan
    x: float = nan
    y: float = nan
    z: float = nan
    rate_x: float = nan
    rate_y: float = nan
    rate_z: float = nan
    force_x: float = nan
    force_y: float = nan
    force_z: float = nan
    velocity_x: float = nan
    velocity_y: float = nan
    velocity_z: float = nan
    depth: float = nan


class NavigationBelief(NamedTuple):
    """Motion of the IMU and its biases, with the covariance of their errors.

    Attributes:
        position, velocity: of the IMU in the earth frame, tuples [m, m/s].
        attitude: of the body in the earth frame, unit quaternion (w, x, y, z).
        gyro_bias, force_bias: in the axes of the IMU [rad/s, m/s^2].
        P: covariance of `ERRORS`, shape (15, 15).
        rate, force: the last readings of the IMU, biases still in them [rad/s, m/s^2].
        status: flags of `NavigationStatus`.
        unseen_...: time since the last measurement that was used [s].
        shut_...: for how long measurements have been refused in a row [s].
    """

    position: Vector
    velocity: Vector
    attitude: Quaternion
    gyro_bias: Vector
    force_bias: Vector
    P: Any
    rate: Vector
    force: Vector
    status: int
    unseen_attitude: float
    unseen_velocity: float
    unseen_depth: float
    shut_attitude: float
    shut_velocity: float
    shut_depth: float


class NavigationInnovation(NamedTuple):
    """What a step's measurements said to its prediction; NaN where one was missing.

    Attributes:
        attitude_x ... depth: measured less predicted: attitude about the earth's axes [rad], velocity in the log's axes
            [m/s], depth [m].
        nis_attitude, nis_velocity: chi-square with 3 degrees; nis_depth: with 1. NaN where not used.
    """

    attitude_x: float
    attitude_y: float
    attitude_z: float
    velocity_x: float
    velocity_y: float
    velocity_z: float
    depth: float
    nis_attitude: float
    nis_velocity: float
    nis_depth: float


class NavigationSettings(NamedTuple):
    """Places and noise that the filter believes in, and its limits.

    Attributes:
        imu_position, velocity_position, depth_position: of the sensors in body axes [m].
        imu_rotation, velocity_rotation: of their axes from the body's, quaternions.
        gravity: [m/s^2].
        attitude_noise [rad], gyro_noise [rad/s], force_noise [m/s^2], velocity_noise [m/s], depth_noise [m]: standard
            deviations of a sample, for each axis.
        gyro_walk [rad/s/sqrt(s)], force_walk [m/s^2/sqrt(s)]: of the biases' random walks.
        gyro_bias_deviation [rad/s], force_bias_deviation [m/s^2], velocity_deviation [m/s], attitude_deviation [rad],
        depth_deviation [m]: at the beginning.
        unknown_rate [rad/s], unknown_force [m/s^2]: deviations of what is held while the IMU tells nothing.
        gate: largest squared innovation over its variance, for each axis.
        patience: refusals in a row [s] after which a measurement is used all the same.
        stale: time without a measurement [s] after which the status says so.
        still_velocity [m/s], still_time [s]: without a velocity log the vehicle is believed to be this slow, as if a
            measurement of rest came once in `still_time`: drag lets no vehicle run away.
    """

    imu_position: Vector = (0.0, 0.0, 0.0)
    imu_rotation: Quaternion = (1.0, 0.0, 0.0, 0.0)
    velocity_position: Vector = (0.0, 0.0, 0.0)
    velocity_rotation: Quaternion = (1.0, 0.0, 0.0, 0.0)
    depth_position: Vector = (0.0, 0.0, 0.0)
    gravity: float = 9.81
    attitude_noise: float = 0.004
    gyro_noise: float = 0.003
    force_noise: float = 0.05
    velocity_noise: float = 0.008
    depth_noise: float = 0.006
    gyro_walk: float = 1e-5
    force_walk: float = 1e-4
    gyro_bias_deviation: float = 0.005
    force_bias_deviation: float = 0.05
    velocity_deviation: float = 0.5
    attitude_deviation: float = 0.5
    depth_deviation: float = 100.0
    unknown_rate: float = 0.5
    unknown_force: float = 1.0
    gate: float = 25.0
    patience: float = 1.0
    stale: float = 1.0
    still_velocity: float = 0.5
    still_time: float = 5.0


def checked_navigation(settings: NavigationSettings) -> NavigationSettings:
    """Return the settings with floats, as kernels expect them.

    Raises:
        ValueError: one sentence for each setting that is wrong.
    """
    given: dict[str, Any] = {}
    problems = []
    for name, value in settings._asdict().items():
        if isinstance(value, tuple):
            given[name] = tuple(float(x) for x in value)
            length = sum(x * x for x in given[name])
            if not isfinite(length) or (name.endswith("rotation") and abs(length - 1.0) > 1e-9):
                expected = "a unit quaternion" if name.endswith("rotation") else "finite numbers"
                problems.append(f"{name}: expected {expected}; found {value!r}")
            continue
        given[name] = float(value)
        positive = not name.endswith(("walk", "deviation", "rate", "force"))
        if not isfinite(given[name]) or given[name] < 0.0 or (positive and given[name] == 0.0):
            problems.append(f"{name}: expected a finite number {'above 0' if positive else '>= 0'}; found {value!r}")
    if problems:
        raise ValueError("; ".join(problems))
    return NavigationSettings(**given)


def navigation_level(status: int) -> Level:
    """Return whether an estimate with this status is to be used."""
    flags = NavigationStatus(int(status))
    if flags == NavigationStatus.INITIAL or flags & _INVALID:
        return Level.INVALID
    return Level.DEGRADED if flags & (NavigationStatus(sum(_WORDS)) & ~_INVALID) else Level.OK


def navigation_reason(status: int) -> str:
    """Return why the level is not OK in words, "" with OK."""
    flags = NavigationStatus(int(status))
    if flags == NavigationStatus.INITIAL:
        return "no step taken yet"
    return "; ".join(words for flag, words in _WORDS.items() if flags & flag)
