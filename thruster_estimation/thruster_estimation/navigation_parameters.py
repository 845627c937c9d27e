"""The navigation node's parameters, and the settings that they ask for."""

from collections.abc import Mapping
from typing import Any

from thruster_estimation.navigation_belief import NavigationSettings, checked_navigation
from thruster_model.equations.attitude import quaternion_from_euler
from thruster_runtime.parameters import Parameter

__all__ = ["NAVIGATION_PARAMETERS", "chosen_settings"]

_PLACES = {"imu": (0.10, 0.0, -0.05), "velocity": (-0.10, 0.0, 0.12), "depth": (-0.15, 0.0, 0.0)}
_WORDS = {"imu": "the IMU", "velocity": "the velocity log", "depth": "the depth sensor"}
_DEFAULTS = NavigationSettings()
_NOISE = (
    ("attitude_noise", "rad", "standard deviation of a measured attitude, about each axis"),
    ("gyro_noise", "rad/s", "standard deviation of a measured angular velocity"),
    ("force_noise", "m/s^2", "standard deviation of a measured specific force"),
    ("velocity_noise", "m/s", "standard deviation of a velocity log's reading"),
    ("depth_noise", "m", "standard deviation of a measured depth"),
    ("gyro_bias_deviation", "rad/s", "standard deviation of the gyro's bias at the start"),
    ("force_bias_deviation", "m/s^2", "standard deviation of the accelerometer's bias at the start"),
    ("gyro_walk", "rad/s/sqrt(s)", "random walk of the gyro's bias"),
    ("force_walk", "m/s^2/sqrt(s)", "random walk of the accelerometer's bias"),
    ("velocity_deviation", "m/s", "standard deviation of the velocity at the start"),
    ("gate", "1", "largest squared innovation over its variance of a measurement that is used"),
    ("patience", "s", "refusals in a row after which a measurement is used all the same"),
    ("stale", "s", "time without a measurement after which the status says so"),
    ("still_velocity", "m/s", "without a velocity log the vehicle is believed to be slower than this"),
    ("still_time", "s", "time in which that belief counts as one measurement"),
    ("gravity", "m/s^2", "gravity"),
)  # fmt: skip
_AT_START = ("gyro_bias_deviation", "force_bias_deviation", "velocity_deviation", "gravity")
_MAY_BE_ZERO = ("walk", "deviation")


def _place(sensor: str) -> list[Parameter]:
    axes = zip("xyz", _PLACES[sensor], strict=True)
    found = [
        Parameter(name=f"{sensor}_{axis}", default=at, unit="m", lower=-100.0, upper=100.0,
                  description=f"place of {_WORDS[sensor]} along the body's {axis}")
        for axis, at in axes
    ]  # fmt: skip
    if sensor == "depth":
        return found
    return found + [
        Parameter(name=f"{sensor}_{turn}", default=0.0, unit="rad", lower=-10.0, upper=10.0,
                  description=f"{turn} of the axes of {_WORDS[sensor]} from the body's (3-2-1)")
        for turn in ("roll", "pitch", "yaw")
    ]  # fmt: skip


def _rate(sensor: str, period: float) -> list[Parameter]:
    return [
        Parameter(
            name=f"{sensor}_every", default=period, unit="s", lower=0.0, upper=60.0,
            description=f"period and delay of {_WORDS[sensor]} together: what is due by then is waited for, until the "
            "next reading of the IMU at most; 0: not waited for",
        ),
        Parameter(
            name=f"{sensor}_first", default=0.0, unit="s", lower=0.0, upper=3600.0,
            description=f"when the first reading of {_WORDS[sensor]} is due; 0: after {sensor}_every",
        ),
        Parameter(
            name=f"{sensor}_timeout", default=1.0, unit="s", lower=0.0, above=True, upper=3600.0,
            description=f"silence after which {_WORDS[sensor]} is not waited for",
        ),
    ]  # fmt: skip


NAVIGATION_PARAMETERS = (
    Parameter(
        name="period", default=0.04, unit="s", lower=0.0, above=True, upper=10.0,
        description="between estimates: one at the IMU's first instant at or after each multiple",
    ),
    Parameter(
        name="rep103", default=False,
        description="whether the estimate also goes out on rov/odometry_enu in the frames map and base_link",
    ),
    *_rate("velocity", 0.2),
    *_rate("depth", 0.1),
    *[parameter for sensor in _PLACES for parameter in _place(sensor)],
    *[
        Parameter(
            name=name, default=getattr(_DEFAULTS, name), unit=unit, description=words, lower=0.0,
            above=not name.endswith(_MAY_BE_ZERO), live=name not in _AT_START,
        )
        for name, unit, words in _NOISE
    ],
)  # fmt: skip


def chosen_settings(values: Mapping[str, Any]) -> NavigationSettings:
    """Return the settings that the values of `NAVIGATION_PARAMETERS` ask for."""

    def place(sensor: str) -> tuple[float, float, float]:
        return values[f"{sensor}_x"], values[f"{sensor}_y"], values[f"{sensor}_z"]

    def turn(sensor: str) -> tuple[float, float, float, float]:
        angles = values[f"{sensor}_roll"], values[f"{sensor}_pitch"], values[f"{sensor}_yaw"]
        w, x, y, z = quaternion_from_euler(angles)
        return w, x, y, z

    return checked_navigation(
        NavigationSettings(
            imu_position=place("imu"),
            imu_rotation=turn("imu"),
            velocity_position=place("velocity"),
            velocity_rotation=turn("velocity"),
            depth_position=place("depth"),
            **{name: values[name] for name, _, _ in _NOISE},
        )
    )
