"""The motion of a vehicle that turns, and its readings in a run."""

import numpy as np
from foreign_recordings import COUNT
from scipy.spatial.transform import Rotation

from run_bag import Run

TIME = 0.04 * np.arange(COUNT)
ANGLES = np.column_stack((0.2 * np.sin(TIME), 0.1 * np.cos(TIME), 3.0 + 0.5 * TIME))  # roll, pitch, yaw [rad]
BODY = Rotation.from_euler("ZYX", ANGLES[:, ::-1])  # body (FRD) to earth (NED)
FORCE = BODY.inv().apply([0.0, 0.0, -9.81])
RATES = np.column_stack((np.sin(3 * TIME), np.cos(2 * TIME), 0.5 + 0 * TIME))
PULSES = 1500 + np.round(100 * np.sin(TIME))


def attitude(run: Run, topic: str = "rov/imu.orientation") -> Rotation:
    """Return the rotations that a quaternion of a run tells."""
    return Rotation.from_quat(np.column_stack([run[f"{topic}.{a}"].values for a in "xyzw"]))


def vectors(run: Run, topic: str) -> np.ndarray:
    """Return a vector of a run, shape (messages, 3)."""
    return np.column_stack([run[f"{topic}.{a}"].values for a in "xyz"])
