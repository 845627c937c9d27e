"""Sensors inside a compiled loop: errors drawn before, readings made where the loop is, of hundreds of runs at once.

A loop goes in ticks of one length. At each it asks `heard_at` for what the navigation filter hears and `speed_at` for
the tachometers; what is not due is NaN. The numbers are those of `live.Sensors`, bit for bit. Sensors whose readings
arrive later than they are stamped are for graphs, where the filter goes back: here they are refused.
"""

from math import ceil, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.sensors.coefficients import SensorCoefficients, sensor_coefficients
from rov_sim.vehicle.sensors.errors import drawn_errors
from rov_sim.vehicle.sensors.measuring import (
    depth_measured,
    imu_measured,
    reading_of,
    speed_measured,
    velocity_measured,
)
from rov_sim.vehicle.sensors.series import readings_late
from rov_sim.vehicle.sensors.settings import COLUMNS, QUANTITIES, VehicleSensors
from thruster_estimation.navigation_belief import Heard
from thruster_model.compilation import equation

__all__ = ["LoopSensors", "heard_at", "loop_sensors", "speed_at"]

Array = NDArray[np.float64]
_NEVER = 2**62
_IMU, _VELOCITY, _DEPTH, _TACHOMETER = (list(QUANTITIES).index(n) for n in ("imu", "velocity", "depth", "tachometer"))


class LoopSensors(NamedTuple):
    """What a loop needs of the sensors of one run.

    Attributes:
        c: `SensorCoefficients`.
        schedule: first tick and ticks between readings by sensor, shape (5, 2).
        imu, velocity, depth: errors of their readings, shape (readings, columns).
        speed: of the tachometers, shape (thrusters, readings, 1).
        waiting: readings of the velocity log between their instants and their stamps, shape (ticks late + 1, 3);
        past: motion at the latest readings of the IMU, shape (readings late + 1, 17). `heard_at` changes both.
    """

    c: SensorCoefficients
    schedule: NDArray[np.int64]
    imu: Array
    velocity: Array
    depth: Array
    speed: Array
    waiting: Array
    past: Array


def loop_sensors(
    sensors: VehicleSensors, seed: int, thrusters: int, ticks: int, tick: int, c: SensorCoefficients | None = None
) -> LoopSensors:
    """Return the sensors of a run of `ticks` ticks of `tick` [ns] each.

    Args:
        sensors: settings.
        seed: of their errors.
        thrusters: how many.
        ticks, tick: of the loop.
        c: coefficients with effects; without them those of the settings.

    Raises:
        ValueError: readings that are not at ticks, or that arrive later than they are stamped.
    """
    c = sensor_coefficients(sensors) if c is None else c
    schedule = np.full((len(QUANTITIES), 2), _NEVER, dtype=np.int64)
    problems = []
    for row, name in enumerate(QUANTITIES):
        if name not in sensors.there():
            continue
        sensor = getattr(sensors, name)
        if sensor.period % tick or sensor.first % tick:
            problems.append(
                f"{name}: expected readings at multiples of {1e-9 * tick:g} s; found them from "
                f"{1e-9 * sensor.first:g} s on, each {1e-9 * sensor.period:g} s"
            )
        if sensor.lateness and name != "battery":
            problems.append(f"{name}: delay: expected 0 s within a compiled loop; found {sensor.delay:g} s")
        schedule[row] = sensor.first // tick, max(sensor.period // tick, 1)
    if problems:
        raise ValueError("; ".join(problems))
    errors = drawn_errors(sensors, seed, thrusters, ticks * tick)
    none = {name: np.empty((0, columns)) for name, columns in COLUMNS.items()}
    found = {name: errors.get((name, -1), none[name]) for name in ("imu", "velocity", "depth")}
    speed = [errors.get(("tachometer", i), none["tachometer"]) for i in range(thrusters)]
    late = ceil(round(1e9 * c.velocity_late) / tick)
    old = readings_late("imu", sensors.imu, c)
    return LoopSensors(
        c, schedule, **found, speed=np.array(speed).reshape(thrusters, -1, 1), waiting=np.full((late + 1, 3), nan),
        past=np.zeros((old + 1, 17)),
    )  # fmt: skip


@equation
def _velocity_at(tick, velocity, s):  # type: ignore[no-untyped-def]
    """Return the velocity (3) [m/s] that counts at a tick; NaN: none."""
    size = s.waiting.shape[0]
    now = s.waiting[tick % size]
    now[:] = nan
    k = reading_of(tick, s.schedule[_VELOCITY, 0], s.schedule[_VELOCITY, 1])
    if k >= 0:
        told = velocity_measured(velocity, s.c, s.velocity[k])
        now[0], now[1], now[2] = told.x, told.y, told.z
    due = s.waiting[(tick + 1) % size]
    return due[0], due[1], due[2]


@equation
def heard_at(tick, position, attitude, velocity, acceleration, current, s):  # type: ignore[no-untyped-def]
    """Return what the navigation filter hears at a tick, 1 being the first: `Heard`, NaN for what is not due.

    Args:
        tick: index.
        position (3,), attitude (4,), velocity (6,), acceleration (6,), current: true states, as for `imu_measured`.
        s: `LoopSensors`.
    """
    w, x, y, z = nan, nan, nan, nan
    a, b, c, f, g, h = nan, nan, nan, nan, nan, nan
    k = reading_of(tick, s.schedule[_IMU, 0], s.schedule[_IMU, 1])
    if k >= 0:
        size = s.past.shape[0]
        now, then = s.past[k % size], s.past[max(k - size + 1, 0) % size]
        now[:4], now[4:10], now[10:16], now[16] = attitude, velocity, acceleration, current
        w, x, y, z, a, b, c, f, g, h = imu_measured(then[:4], then[4:10], then[10:16], then[16], s.c, s.imu[k])
    u, v, d = _velocity_at(tick, velocity, s)
    deep = nan
    k = reading_of(tick, s.schedule[_DEPTH, 0], s.schedule[_DEPTH, 1])
    if k >= 0:
        deep = depth_measured(position, attitude, s.c, s.depth[k])
    return Heard(w, x, y, z, a, b, c, f, g, h, u, v, d, deep)


@equation
def speed_at(tick, i, n, s):  # type: ignore[no-untyped-def]
    """Return the rotor speed [rad/s] told of thruster i, which turns at n [rad/s]; NaN where no reading is due."""
    k = reading_of(tick, s.schedule[_TACHOMETER, 0], s.schedule[_TACHOMETER, 1])
    return speed_measured(n, s.c, s.speed[i, k]) if k >= 0 else nan
