"""The sensors of a vehicle period by period: each reads at its own instants, what it reads arrives after its delay."""

from math import gcd
from typing import NamedTuple

from rov_sim.vehicle.sensors.coefficients import SensorCoefficients, sensor_coefficients
from rov_sim.vehicle.sensors.errors import streams
from rov_sim.vehicle.sensors.series import Rows, Truth, measured_rows, rows_of, stamp_and_arrival
from rov_sim.vehicle.sensors.settings import Sensor, VehicleSensors

__all__ = ["Reading", "Sensors"]


class Reading(NamedTuple):
    """What one sensor told.

    Attributes:
        sensor: imu, velocity, depth, tachometer or battery.
        thruster: whose tachometer, -1: a sensor of the vehicle.
        stamp: what the sensor says the instant of measurement is [ns].
        taken: when it was [ns].
        values: in the order and units of `measuring`'s readings; NaN: it holds nothing.
    """

    sensor: str
    thruster: int
    stamp: int
    taken: int
    values: tuple[float, ...]


class Sensors:
    """All sensors of one vehicle in one run; their readings depend on settings, seed and truth alone."""

    def __init__(self, sensors: VehicleSensors, seed: int, thrusters: int, c: SensorCoefficients | None = None) -> None:
        """Begin at time 0 with errors of `seed`; `c`: coefficients with effects, without them those of the settings."""
        self._sensors, self._c = sensors, sensor_coefficients(sensors) if c is None else c
        self._streams = streams(sensors, seed, thrusters)
        self._next = {key: self._sensor(key).first for key in self._streams}
        self._waiting: list[tuple[int, Reading]] = []

    def _sensor(self, key: tuple[str, int]) -> Sensor:
        sensor: Sensor = getattr(self._sensors, key[0])
        return sensor

    @property
    def tick(self) -> int:
        """The longest time whose multiples hold all instants of all sensors [ns]; 0 without any sensor."""
        return gcd(*(each for key in self._streams for each in (self._sensor(key).first, self._sensor(key).period)))

    @property
    def next_instant(self) -> int | None:
        """When the next sensor reads [ns], None without any."""
        return min(self._next.values(), default=None)

    def read(self, now: int, truth: Truth) -> tuple[Reading, ...]:
        """Return the readings that are there at `now` [ns] and were not before, by arrival.

        Args:
            now: an instant after those of former calls, none of a sensor's left out between.
            truth: the true states at `now`.

        Raises:
            ValueError: an instant of a sensor was left out.
        """
        due = [key for key, instant in self._next.items() if instant <= now]
        rows = rows_of(truth, None) if due else None
        for key in due:
            self._take(key, now, rows)
        arrived = [reading for at, reading in self._waiting if at <= now]
        if arrived:
            self._waiting = [each for each in self._waiting if each[0] > now]
        return tuple(arrived)

    def _take(self, key: tuple[str, int], now: int, rows: Rows | None) -> None:
        name, thruster = key
        sensor, instant = self._sensor(key), self._next[key]
        if instant != now:
            raise ValueError(
                f"{name}: expected to be read at {1e-9 * instant:.9g} s; found {1e-9 * now:.9g} s: advance the vehicle "
                f"by {1e-9 * self.tick:g} s or a part of it"
            )
        self._next[key] = instant + sensor.period
        values = measured_rows(name, thruster, rows, self._c, self._streams[key].next()[None])[0]
        stamp, at = stamp_and_arrival(name, sensor, instant, self._c)
        self._waiting.append((int(at), Reading(name, thruster, int(stamp), instant, tuple(values.tolist()))))
        self._waiting.sort(key=lambda each: each[0])
