"""What the navigation filter believes of a vehicle's sensors: their places and noise as set, without any effect."""

from math import hypot

from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.settings import VehicleSensors
from thruster_estimation.navigation_belief import NavigationSettings, checked_navigation

__all__ = ["navigation_settings"]

_LEAST = 1e-6


def navigation_settings(sensors: VehicleSensors, gravity: float = 9.81) -> NavigationSettings:
    """Return settings for these sensors; where the axes of a sensor differ, the largest noise counts for all.

    A sensor without noise is believed to have very little; biases to scatter by what is set, deviation and value.
    """
    c, imu = sensor_coefficients(sensors, gravity), sensors.imu

    def largest(values: tuple[float, ...]) -> float:
        return max(*values, _LEAST)

    bias = [hypot(b, d) for b, d in zip(imu.bias, imu.bias_deviation, strict=True)]
    return checked_navigation(
        NavigationSettings(
            imu_position=c.imu_position,
            imu_rotation=c.imu_rotation,
            velocity_position=c.velocity_position,
            velocity_rotation=c.velocity_rotation,
            depth_position=c.depth_position,
            gravity=gravity,
            attitude_noise=largest(imu.noise[:3]),
            gyro_noise=largest(imu.noise[3:6]),
            force_noise=largest(imu.noise[6:9]),
            velocity_noise=largest(sensors.velocity.noise),
            depth_noise=max(sensors.depth.noise[0], _LEAST),
            gyro_bias_deviation=largest(tuple(bias[3:6])),
            force_bias_deviation=largest(tuple(bias[6:9])),
        )
    )
