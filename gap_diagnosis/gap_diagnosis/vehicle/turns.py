"""What sensors tell that are mounted turned, and what that is in the body's axes.

With R from a sensor's axes to the body's, a vector y_s of the sensor is R y_s, and an attitude q that was told with its
turn is q * q(R)^-1.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rov_sim.vehicle.sensors.coefficients import Vector
from thruster_model.equations.attitude import quaternion_from_euler

__all__ = ["Stated", "attitudes_with", "read_with", "rotations"]

Array = NDArray[np.float64]
_PART = 0.01
"""Of a reading, that another axis has to have in it to be missed where it is not told: pi/2 is stated as 1.571."""


class Stated(NamedTuple):
    """Roll, pitch, yaw from the body's axes to those of IMU and velocity log, as a set states them [rad]."""

    imu: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)

    @property
    def mountings(self) -> tuple[Array, Array]:
        """R of both."""
        imu, velocity = (rotations(np.array([quaternion_from_euler(turn)])).as_matrix()[0] for turn in self)
        return imu, velocity


def read_with(y: Array, R: Array) -> Array:
    """Return vectors (..., 3) of the sensor in the body's axes; NaN where an axis is not told that is part of it."""
    missing = np.isnan(y) @ (np.abs(R) > _PART).T
    return np.where(missing, np.nan, np.nan_to_num(y) @ R.T)


def attitudes_with(q: Array, R: Array) -> Array:
    """Return the body's attitudes (K, 4), (w, x, y, z), of those that were told with the turn of a sensor."""
    return np.asarray((rotations(q) * Rotation.from_matrix(R).inv()).as_quat()[:, [3, 0, 1, 2]])


def rotations(q: Array) -> Rotation:
    """Return attitudes (K, 4), (w, x, y, z)."""
    return Rotation.from_quat(q[:, [1, 2, 3, 0]])
