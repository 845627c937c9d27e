r"""Set points of a vehicle from an operator's stick: speeds as asked for, an attitude that turns while it is pushed.

    stick (surge, sway, heave [m/s]; rates of roll, pitch, yaw [rad/s])  ->  cut at the largest  ->  ramp
    velocity and attitude rate follow it at most at `acceleration`, `turning`;   attitude = its integral

Without a stick (the deadman: none, too old, or not finite) velocity and attitude rate run down by the same ramps: the
vehicle stops and keeps its attitude. Roll and pitch stay within `tilt`.
"""

import math
from typing import NamedTuple

from thruster_control.outer_loop.settings import VehicleSetPoint

__all__ = ["OperatorSettings", "OperatorTrack", "operated"]

Vector = tuple[float, float, float]


class OperatorSettings(NamedTuple):
    """Largest speed [m/s] and attitude rate [rad/s] of each axis, their ramps [m/s^2, rad/s^2], largest tilt [rad]."""

    speed: float = 0.5
    rate: float = 0.5
    acceleration: float = 0.5
    turning: float = 1.0
    tilt: float = 1.0


class OperatorTrack(NamedTuple):
    """What was asked for last: attitude and its rate (roll, pitch, yaw) [rad, rad/s], velocity [m/s]."""

    attitude: Vector = (0.0, 0.0, 0.0)
    rate: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)


def _ramped(before: Vector, wanted: Vector, most: float, dt: float) -> tuple[Vector, Vector]:
    """Return (value, its rate) after dt [s]."""
    steps = [min(max(to - at, -most * dt), most * dt) for at, to in zip(before, wanted, strict=True)]
    x, y, z = (at + step for at, step in zip(before, steps, strict=True))
    return (x, y, z), (steps[0] / dt, steps[1] / dt, steps[2] / dt)


def operated(
    track: OperatorTrack, stick: tuple[Vector, Vector] | None, dt: float, settings: OperatorSettings
) -> tuple[OperatorTrack, VehicleSetPoint]:
    """Return the track after dt [s], and the set point.

    `stick`: (surge, sway, heave) and rates of (roll, pitch, yaw); None for none.
    """
    if not 0.0 < dt < math.inf:
        return track, VehicleSetPoint(track.attitude, track.rate, (0.0, 0.0, 0.0), track.velocity, (0.0, 0.0, 0.0))
    held = stick is not None and all(math.isfinite(x) for part in stick for x in part)
    moving, turning = stick if held and stick is not None else ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    s, r = settings.speed, settings.rate
    wanted = min(max(moving[0], -s), s), min(max(moving[1], -s), s), min(max(moving[2], -s), s)
    rates = [min(max(x, -r), r) for x in turning]
    for i in (0, 1):
        if rates[i] * track.attitude[i] > 0.0 and abs(track.attitude[i]) >= settings.tilt:
            rates[i] = 0.0
    velocity, acceleration = _ramped(track.velocity, wanted, settings.acceleration, dt)
    rate, angular = _ramped(track.rate, (rates[0], rates[1], rates[2]), settings.turning, dt)
    before = track.attitude
    attitude = before[0] + rate[0] * dt, before[1] + rate[1] * dt, math.remainder(before[2] + rate[2] * dt, math.tau)
    return OperatorTrack(attitude, rate, velocity), VehicleSetPoint(attitude, rate, angular, velocity, acceleration)
