"""What a reading is made of beside the truth: the place of each sensor and its systematic errors, for kernels.

Settings give the places; effects change any of it. At the values of `sensor_coefficients` the errors change nothing.
"""

from typing import NamedTuple

from rov_sim.vehicle.sensors.settings import VehicleSensors
from thruster_model.equations.attitude import quaternion_from_euler

__all__ = ["Quaternion", "SensorCoefficients", "Vector", "sensor_coefficients"]

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]


class SensorCoefficients(NamedTuple):
    """Places and systematic errors of a vehicle's sensors.

    Attributes:
        gravity: [m/s^2].
        imu_position: of the IMU in body axes [m]; imu_rotation: of its axes, as a quaternion.
        imu_late: by which all that it tells is older than its stamps [s].
        gyro_scale, gyro_bias: rates times the one plus the other [1, rad/s], in the axes of the IMU.
        force_bias: of the specific force [m/s^2], in the axes of the IMU.
        attitude_bias: by which the attitude is turned further than the IMU, about its axes [rad].
        heading_bias: error of the yaw [rad].
        magnetic_yaw: error of the yaw at all thrusters' full current [rad].
        compass: errors of the yaw by the heading psi [rad]: times sin psi, cos psi, sin 2 psi, cos 2 psi.
        velocity_position, velocity_rotation: of the velocity log, as for the IMU.
        velocity_scale: velocities times this [1], in its axes; velocity_late: by which its stamps are late [s].
        imu_read, velocity_read: turns from a sensor's axes to those in which a filter takes its readings, as
            quaternions; a plant's sensors tell in their own, and do not ask.
        depth_position: of the depth sensor [m]; depths times depth_scale [1], and depth_bias added [m].
        signed: 1 where tachometers tell the direction, else 0.
        nominal_voltage [V], current_at_full [A], idle_current [A]: of the battery.
    """

    gravity: float
    imu_position: Vector
    imu_rotation: Quaternion
    imu_late: float
    gyro_scale: Vector
    gyro_bias: Vector
    force_bias: Vector
    attitude_bias: Vector
    heading_bias: float
    magnetic_yaw: float
    compass: tuple[float, float, float, float]
    velocity_position: Vector
    velocity_rotation: Quaternion
    velocity_scale: Vector
    velocity_late: float
    imu_read: Quaternion
    velocity_read: Quaternion
    depth_position: Vector
    depth_scale: float
    depth_bias: float
    signed: int
    nominal_voltage: float
    current_at_full: float
    idle_current: float


def sensor_coefficients(sensors: VehicleSensors, gravity: float = 9.81) -> SensorCoefficients:
    """Return the coefficients of these sensors without any systematic error."""
    nothing, whole = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
    return SensorCoefficients(
        gravity=gravity,
        imu_position=sensors.imu.position,
        imu_rotation=_turn(sensors.imu.rotation),
        imu_late=0.0,
        gyro_scale=whole,
        gyro_bias=nothing,
        force_bias=nothing,
        attitude_bias=nothing,
        heading_bias=0.0,
        magnetic_yaw=0.0,
        compass=(0.0, 0.0, 0.0, 0.0),
        velocity_position=sensors.velocity.position,
        velocity_rotation=_turn(sensors.velocity.rotation),
        velocity_scale=whole,
        velocity_late=0.0,
        imu_read=(1.0, 0.0, 0.0, 0.0),
        velocity_read=(1.0, 0.0, 0.0, 0.0),
        depth_position=sensors.depth.position,
        depth_scale=1.0,
        depth_bias=0.0,
        signed=int(sensors.signed),
        nominal_voltage=sensors.nominal_voltage,
        current_at_full=sensors.current_at_full,
        idle_current=sensors.idle_current,
    )


def _turn(angles: Vector) -> Quaternion:
    w, x, y, z = quaternion_from_euler(angles)
    return float(w), float(x), float(y), float(z)
