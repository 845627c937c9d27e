"""Readings over whole trajectories, the same numbers as live ones, and the compiled loops that make both."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.sensors.coefficients import SensorCoefficients, sensor_coefficients
from rov_sim.vehicle.sensors.errors import drawn_errors
from rov_sim.vehicle.sensors.measuring import (
    battery_measured,
    depth_measured,
    imu_measured,
    speed_measured,
    velocity_measured,
)
from rov_sim.vehicle.sensors.settings import Sensor, VehicleSensors
from rov_sim.vehicle.sensors.tachometers import SENSED_BY_TACHOMETERS, TachometerChains
from thruster_model.compilation import compiled

__all__ = ["WIDTHS", "Series", "Truth", "measured_rows", "read_trajectory", "readings_late", "stamp_and_arrival"]

Array = NDArray[np.float64]
Instants = NDArray[np.int64]

WIDTHS: Mapping[str, int] = {"imu": 10, "velocity": 3, "depth": 1, "tachometer": 1, "battery": 2}
"""How many values a reading of each sensor has."""


class Truth(Protocol):
    """True states, at one instant or with one more axis in front over a trajectory; N thrusters.

    position (3,) [m], attitude (4,), velocity (6,) [m/s, rad/s], acceleration (6,) [m/s^2, rad/s^2], n (N,) [rad/s],
    supply, relative voltage, current, relative.
    """

    @property
    def position(self) -> Any: ...
    @property
    def attitude(self) -> Any: ...
    @property
    def velocity(self) -> Any: ...
    @property
    def acceleration(self) -> Any: ...
    @property
    def n(self) -> Any: ...
    @property
    def supply(self) -> Any: ...
    @property
    def current(self) -> Any: ...


class Series(NamedTuple):
    """The readings of one sensor, K of them.

    Attributes:
        taken: instants of measurement [ns], shape (K,).
        stamps: what the sensor says these instants are [ns].
        available: when each is there [ns].
        values: shape (K, WIDTHS), in the order and units of `measuring`'s readings; NaN: it holds nothing.
    """

    taken: Instants
    stamps: Instants
    available: Instants
    values: Array


@compiled
def imu_rows(attitude, velocity, acceleration, current, c, errors, out):  # type: ignore[no-untyped-def]
    """Fill `out` (K, 10) with what the IMU tells at K instants."""
    for k in range(out.shape[0]):
        told = imu_measured(attitude[k], velocity[k], acceleration[k], current[k], c, errors[k])
        for j in range(10):
            out[k, j] = told[j]


@compiled
def velocity_rows(velocity, c, errors, out):  # type: ignore[no-untyped-def]
    """Fill `out` (K, 3) with what the velocity log tells."""
    for k in range(out.shape[0]):
        told = velocity_measured(velocity[k], c, errors[k])
        out[k, 0], out[k, 1], out[k, 2] = told.x, told.y, told.z


@compiled
def depth_rows(position, attitude, c, errors, out):  # type: ignore[no-untyped-def]
    """Fill `out` (K, 1) with what the depth sensor tells."""
    for k in range(out.shape[0]):
        out[k, 0] = depth_measured(position[k], attitude[k], c, errors[k])


@compiled
def speed_rows(n, c, errors, out):  # type: ignore[no-untyped-def]
    """Fill `out` (K, 1) with what the tachometer tells of n (K,)."""
    for k in range(out.shape[0]):
        out[k, 0] = speed_measured(n[k], c, errors[k])


@compiled
def battery_rows(supply, current, c, errors, out):  # type: ignore[no-untyped-def]
    """Fill `out` (K, 2) with what the battery tells."""
    for k in range(out.shape[0]):
        told = battery_measured(supply[k], current[k], c, errors[k])
        out[k, 0], out[k, 1] = told.voltage, told.current


def measured_rows(name: str, thruster: int, rows: Any, c: SensorCoefficients, errors: Array) -> Array:
    """Return what a sensor tells at K instants, shape (K, WIDTHS).

    Args:
        name, thruster: of the sensor; -1: none.
        rows: a `Truth` over K instants.
        c: its coefficients.
        errors: shape (K, columns).
    """
    out = np.empty((len(errors), WIDTHS[name]))
    if name == "imu":
        imu_rows(rows.attitude, rows.velocity, rows.acceleration, rows.current, c, errors, out)
    elif name == "velocity":
        velocity_rows(rows.velocity, c, errors, out)
    elif name == "depth":
        depth_rows(rows.position, rows.attitude, c, errors, out)
    elif name == "tachometer":
        speed_rows(np.ascontiguousarray(rows.n[:, thruster]), c, errors, out)
    else:
        battery_rows(rows.supply, rows.current, c, errors, out)
    return out


class Rows(NamedTuple):
    """A `Truth` over several instants."""

    position: Array
    attitude: Array
    velocity: Array
    acceleration: Array
    n: Array
    supply: Array
    current: Array


def rows_of(truth: Truth, pick: Any, told: Array | None = None) -> Rows:
    """Return the rows `pick` of a truth; `None` makes one row of an instant.

    told: rotor speeds of these rows as tachometers' effects leave them, instead of the true ones.
    """
    given = [np.asarray(getattr(truth, name), dtype=np.float64)[pick] for name in Rows._fields]
    rows = Rows(*(np.ascontiguousarray(each) for each in given))
    return rows if told is None else rows._replace(n=told)


def stamp_and_arrival(name: str, sensor: Sensor, taken: Any, c: SensorCoefficients) -> tuple[Any, Any]:
    """Return (stamp, when it is there) [ns] of readings taken at `taken` [ns]; none is there before its stamp."""
    stamp = taken + (round(1e9 * c.velocity_late) if name == "velocity" else 0)
    return stamp, np.maximum(taken + sensor.lateness, stamp)


def readings_late(name: str, sensor: Sensor, c: SensorCoefficients) -> int:
    """Return by how many of its readings a sensor tells what was before, under a stamp that is right."""
    return round(1e9 * c.imu_late / sensor.period) if name == "imu" else 0


def read_trajectory(
    sensors: VehicleSensors,
    seed: int,
    trajectory: Any,
    c: SensorCoefficients | None = None,
    effects: Sequence[Any] | None = None,
) -> dict[tuple[str, int], Series]:
    """Return the readings along a trajectory by sensor and thruster (-1: of the vehicle).

    Args:
        sensors: settings.
        seed: of their errors.
        trajectory: a `Truth` with its `time` (K,) [s] from the start, which holds every instant of every sensor.
        c: coefficients with effects; without them those of the settings.
        effects: `EffectValues` of each thruster, whose tachometers they change; None: none do.

    Raises:
        ValueError: an instant of a sensor that is none of the trajectory.
    """
    c = sensor_coefficients(sensors) if c is None else c
    time = np.round(1e9 * np.asarray(trajectory.time)).astype(np.int64)
    found, told = {}, None
    if effects is not None and sensors.tachometer.rate > 0.0:
        told = _told(sensors.tachometer, seed, trajectory, time, effects)
    for (name, i), errors in drawn_errors(sensors, seed, np.shape(trajectory.n)[1], int(time[-1])).items():
        sensor: Sensor = getattr(sensors, name)
        taken = sensor.first + sensor.period * np.arange(len(errors), dtype=np.int64)
        at = _places(name, time, taken)[np.maximum(np.arange(len(taken)) - readings_late(name, sensor, c), 0)]
        values = measured_rows(name, i, rows_of(trajectory, at, None if told is None else told[at]), c, errors)
        found[name, i] = Series(taken, *stamp_and_arrival(name, sensor, taken, c), values)
    return found


def _told(tachometer: Sensor, seed: int, trajectory: Any, time: Instants, effects: Sequence[Any]) -> Array:
    """Return what the effects of tachometers make of all rotor speeds (K, N); NaN between the chains' steps."""
    chains = TachometerChains(tachometer, effects, seed)
    at = _places("tachometer", time, chains.step * np.arange(1, int(time[-1]) // chains.step + 1, dtype=np.int64))
    told = np.full(np.shape(trajectory.n), np.nan)
    told[at] = chains.told(*(np.asarray(getattr(trajectory, name))[at] for name in SENSED_BY_TACHOMETERS))
    return told


def _places(name: str, time: Instants, taken: Instants) -> Instants:
    """Return where in `time` the instants of a sensor are, all [ns]."""
    at = np.minimum(np.searchsorted(time, taken), len(time) - 1)
    missing = np.flatnonzero(time[at] != taken)
    if missing.size:
        raise ValueError(
            f"{name}: expected the trajectory at every instant of this sensor; found nothing at "
            f"{1e-9 * taken[missing[0]]:.9g} s, though it lasts from {1e-9 * time[0]:g} to {1e-9 * time[-1]:g} s"
        )
    return at
