"""What the navigation filter believes of a vehicle's sensors: their places and noise as set, without any effect."""

from math import hypot

from rov_sim.vehicle.sensors.coefficients import SensorCoefficients, sensor_coefficients
from rov_sim.vehicle.sensors.settings import VehicleSensors
from thruster_estimation.navigation_belief import NavigationSettings, checked_navigation

__all__ = ["navigation_parameters", "navigation_settings"]

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


def navigation_parameters(sensors: VehicleSensors, c: SensorCoefficients | None = None) -> dict[str, float]:
    """Return the navigation node's parameters in lockstep with these sensors.

    Args:
        sensors: settings, which are believed.
        c: coefficients with effects; of these late stamps count, as what is waited for hangs on them.
    """
    believed, late = navigation_settings(sensors), 0.0 if c is None else c.velocity_late
    found: dict[str, float] = {}
    for name in ("imu", "velocity", "depth"):
        sensor = getattr(sensors, name)
        found |= {f"{name}_{axis}": at for axis, at in zip("xyz", sensor.position, strict=True)}
        if name != "depth":
            turns = zip(("roll", "pitch", "yaw"), sensor.rotation, strict=True)
            found |= {f"{name}_{turn}": angle for turn, angle in turns}
        if name != "imu":
            there = sensor.rate > 0.0
            stamped = late if name == "velocity" else 0.0  # none is there before its stamp
            found[f"{name}_every"] = 1e-9 * sensor.period + max(sensor.delay - stamped, 0.0) if there else 0.0
            found[f"{name}_first"] = 1e-9 * sensor.first + max(sensor.delay, stamped) if there else 0.0
    noises = ("attitude", "gyro", "force", "velocity", "depth")
    found |= {f"{name}_noise": getattr(believed, f"{name}_noise") for name in noises}
    return found
