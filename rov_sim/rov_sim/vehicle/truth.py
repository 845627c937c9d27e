"""What is true of a simulated vehicle: its state, and what follows from it at an instant or over a run."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rov_sim.vehicle.tables import BODY
from thruster_model.equations.attitude import quaternion_from_euler

__all__ = ["VehicleState", "VehicleTrajectory", "VehicleTruth", "at_rest", "trajectory_of", "truth_of"]

Array = NDArray[np.float64]


class VehicleState(NamedTuple):
    """Position (3,) [m], earth axes; attitude q (4,); velocity nu (6,) [m/s, rad/s]; thrusters (N, 4): rotor speed
    [rad/s], axial flow [m/s], acting throttle [V], heat."""

    position: Array
    attitude: Array
    velocity: Array
    thrusters: Array


def at_rest(
    thrusters: int,
    *,
    position: ArrayLike = (0.0, 0.0, 0.0),
    angles: ArrayLike = (0.0, 0.0, 0.0),
    velocity: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
) -> VehicleState:
    """Return a vehicle with idle thrusters; angles: roll, pitch, yaw [rad]."""
    q = np.array(quaternion_from_euler(tuple(np.asarray(angles, dtype=np.float64))))
    return VehicleState(np.array(position, float), q, np.array(velocity, float), np.zeros((thrusters, 4)))


class VehicleTruth(NamedTuple):
    """At an instant; in a `VehicleTrajectory` with one more axis in front.

    time [s]; position (3,) [m], earth axes; attitude q (4,); velocity (6,), acceleration dnu/dt (6,), body axes
    [m, rad, s]; supply: relative voltage; current: drawn, as a share of that with all thrusters at full; of each
    thruster (N,): n [rad/s], axial, ambient [m/s], u: acting throttle [V], thrust on the vehicle [N], torque [N m].
    """

    time: float
    position: Array
    attitude: Array
    velocity: Array
    acceleration: Array
    supply: float
    current: float
    n: Array
    axial: Array
    ambient: Array
    u: Array
    thrust: Array
    torque: Array


class VehicleTrajectory(NamedTuple):
    """`VehicleTruth` at K + 1 instants: time, supply, current (K + 1,), the others (K + 1, ...); `final`: the state."""

    time: Array
    position: Array
    attitude: Array
    velocity: Array
    acceleration: Array
    supply: Array
    current: Array
    n: Array
    axial: Array
    ambient: Array
    u: Array
    thrust: Array
    torque: Array
    final: VehicleState

    def at(self, k: int) -> VehicleTruth:
        """Return the truth at instant k."""
        return VehicleTruth(*(row[k] for row in self[:-1]))  # type: ignore[arg-type]


def _parts(rows: Array) -> tuple[Array, ...]:
    """Return the parts of rows (..., `record_width`) as `kernel.measured` fills them."""
    at = BODY + 8
    N = (rows.shape[-1] - at) // 6
    body = (rows[..., :3], rows[..., 3:7], rows[..., 7:BODY], rows[..., BODY : BODY + 6])
    return (
        *body, rows[..., BODY + 6], rows[..., BODY + 7], *(rows[..., at + i * N : at + (i + 1) * N] for i in range(6)),
    )  # fmt: skip


def truth_of(time: float, row: Array) -> VehicleTruth:
    """Return the truth of one row of `kernel.measured`."""
    position, attitude, velocity, acceleration, supply, current, *thrusters = _parts(row)
    return VehicleTruth(
        time, position, attitude, velocity, acceleration, float(supply), float(current), *thrusters
    )  # fmt: skip


def trajectory_of(time: Array, rows: Array, final: VehicleState) -> VehicleTrajectory:
    """Return the trajectory of rows (K + 1, `record_width`)."""
    return VehicleTrajectory(*(time, *_parts(rows), final))  # type: ignore[arg-type]
