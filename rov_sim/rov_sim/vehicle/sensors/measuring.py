r"""What each sensor tells at an instant: of the truth, its coefficients `c` and the random errors of this reading.

With R of the body's attitude q (body to earth), R_s of the sensor's axes and r of its place, both in body axes:

attitude          q_yaw * q * q_s * exp((b + e) / 2)         b = c.attitude_bias; q_yaw: error of the yaw about down,
                  c.heading_bias + c.magnetic_yaw i + c.compass . (sin psi, cos psi, sin 2 psi, cos 2 psi)
angular velocity  c.gyro_scale R_s^T omega + c.gyro_bias + e                                       [rad/s]
specific force    R_s^T (a - R^T g) + c.force_bias + e                                             [m/s^2]
                  a = dnu_1/dt + omega x nu_1 + domega/dt x r + omega x (omega x r)
velocity          c.velocity_scale R_s^T (nu_1 + omega x r) + e                       over ground  [m/s]
depth             c.depth_scale (z + (R r)_z) + c.depth_bias + e                                   [m]
rotor speed       n + e, or |n + e|                                                                [rad/s]
battery           V_0 V/V_0 + e [V],    I_0 + I_full i + e [A]

i is the current of all thrusters as a share of that with all at full, V/V_0 the relative supply voltage. Errors that
are NaN give readings that are NaN. All of these are plain functions of numbers: in a kernel call them as they are, from
Python the compiled ones of `live`, which give the same bits.
"""

from math import cos, sin, sqrt
from typing import NamedTuple

from thruster_model.compilation import equation
from thruster_model.equations.attitude import cross, quaternion_product, rotated, rotated_back
from thruster_model.equations.rotation_vector import rotation

__all__ = [
    "BatteryReading", "ImuReading", "VelocityReading", "battery_measured", "depth_measured",
    "imu_measured", "reading_of", "speed_measured", "velocity_measured",
]  # fmt: skip


class ImuReading(NamedTuple):
    """In the axes of the IMU: attitude of these axes in the earth frame, quaternion (w, x, y, z); angular velocity
    [rad/s]; specific force [m/s^2]."""

    w: float
    x: float
    y: float
    z: float
    rate_x: float
    rate_y: float
    rate_z: float
    force_x: float
    force_y: float
    force_z: float


class VelocityReading(NamedTuple):
    """Velocity of the log's place over ground, in its axes [m/s]."""

    x: float
    y: float
    z: float


class BatteryReading(NamedTuple):
    """Voltage [V] and current drawn [A]."""

    voltage: float
    current: float


@equation
def _compass_deviation(q, terms):  # type: ignore[no-untyped-def]
    """Return the error of the yaw at an attitude [rad]; none where the nose points up or down and has no heading."""
    north, east, _ = rotated(q, (1.0, 0.0, 0.0))
    level = sqrt(north * north + east * east)
    if level < 1e-6:
        return 0.0
    c, s = north / level, east / level
    return terms[0] * s + terms[1] * c + terms[2] * 2.0 * s * c + terms[3] * (c * c - s * s)


@equation
def imu_measured(attitude, velocity, acceleration, current, c, e):  # type: ignore[no-untyped-def]
    """Return the `ImuReading`.

    Args:
        attitude: q (4,); velocity: nu (6,) [m/s, rad/s]; acceleration: dnu/dt (6,) [m/s^2, rad/s^2], all of the body.
        current: of all thrusters, relative.
        c: `SensorCoefficients`.
        e: errors (9,) [rad, rad/s, m/s^2].
    """
    q = (attitude[0], attitude[1], attitude[2], attitude[3])
    nu = (velocity[0], velocity[1], velocity[2])
    omega = (velocity[3], velocity[4], velocity[5])
    turning = (acceleration[3], acceleration[4], acceleration[5])
    yaw = c.heading_bias + c.magnetic_yaw * current + _compass_deviation(q, c.compass)
    told = quaternion_product((cos(0.5 * yaw), 0.0, 0.0, sin(0.5 * yaw)), q)
    b = c.attitude_bias
    turned = rotation((b[0] + e[0], b[1] + e[1], b[2] + e[2]))
    told = quaternion_product(quaternion_product(told, c.imu_rotation), turned)
    r = c.imu_position
    coriolis, euler, centripetal = cross(omega, nu), cross(turning, r), cross(omega, cross(omega, r))
    g = rotated_back(q, (0.0, 0.0, c.gravity))
    force = (
        acceleration[0] + coriolis[0] + euler[0] + centripetal[0] - g[0],
        acceleration[1] + coriolis[1] + euler[1] + centripetal[1] - g[1],
        acceleration[2] + coriolis[2] + euler[2] + centripetal[2] - g[2],
    )
    force = rotated_back(c.imu_rotation, force)
    rate = rotated_back(c.imu_rotation, omega)
    return ImuReading(
        told[0],
        told[1],
        told[2],
        told[3],
        c.gyro_scale[0] * rate[0] + c.gyro_bias[0] + e[3],
        c.gyro_scale[1] * rate[1] + c.gyro_bias[1] + e[4],
        c.gyro_scale[2] * rate[2] + c.gyro_bias[2] + e[5],
        force[0] + c.force_bias[0] + e[6],
        force[1] + c.force_bias[1] + e[7],
        force[2] + c.force_bias[2] + e[8],
    )


@equation
def velocity_measured(velocity, c, e):  # type: ignore[no-untyped-def]
    """Return the `VelocityReading` of nu (6,) [m/s, rad/s] with errors e (3,) [m/s]."""
    r, omega = c.velocity_position, (velocity[3], velocity[4], velocity[5])
    lever = cross(omega, r)
    here = rotated_back(c.velocity_rotation, (velocity[0] + lever[0], velocity[1] + lever[1], velocity[2] + lever[2]))
    return VelocityReading(
        c.velocity_scale[0] * here[0] + e[0], c.velocity_scale[1] * here[1] + e[1], c.velocity_scale[2] * here[2] + e[2]
    )


@equation
def depth_measured(position, attitude, c, e):  # type: ignore[no-untyped-def]
    """Return the depth [m] told at the body's position (3,) [m] and attitude q (4,) with errors e (1,) [m]."""
    lever = rotated((attitude[0], attitude[1], attitude[2], attitude[3]), c.depth_position)
    return c.depth_scale * (position[2] + lever[2]) + c.depth_bias + e[0]


@equation
def speed_measured(n, c, e):  # type: ignore[no-untyped-def]
    """Return the rotor speed [rad/s] told of n [rad/s] with errors e (1,) [rad/s]; its magnitude where unsigned."""
    told = n + e[0]
    return told if c.signed else abs(told)


@equation
def battery_measured(supply, current, c, e):  # type: ignore[no-untyped-def]
    """Return the `BatteryReading` of the relative supply voltage and current with errors e (2,) [V, A]."""
    return BatteryReading(c.nominal_voltage * supply + e[0], c.idle_current + c.current_at_full * current + e[1])


@equation
def reading_of(tick, first, every):  # type: ignore[no-untyped-def]
    """Return which reading a sensor takes at a tick of a loop, -1: none; the first at `first`, then each `every`."""
    since = tick - first
    return since // every if since >= 0 and since % every == 0 else -1
