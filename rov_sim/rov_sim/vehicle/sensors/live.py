"""The sensors of a vehicle period by period: each reads at its own instants, what it reads arrives after its delay."""

from collections import deque
from collections.abc import Sequence
from math import gcd
from typing import Any, NamedTuple

from rov_sim.vehicle.sensors.coefficients import SensorCoefficients, sensor_coefficients
from rov_sim.vehicle.sensors.errors import streams
from rov_sim.vehicle.sensors.series import Rows, Truth, measured_rows, readings_late, rows_of, stamp_and_arrival
from rov_sim.vehicle.sensors.settings import Sensor, VehicleSensors
from rov_sim.vehicle.sensors.tachometers import SENSED_BY_TACHOMETERS, TachometerChains

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

    def __init__(
        self,
        sensors: VehicleSensors,
        seed: int,
        thrusters: int,
        c: SensorCoefficients | None = None,
        effects: Sequence[Any] | None = None,
    ) -> None:
        """Begin at time 0.

        Args:
            sensors: settings.
            seed: of their errors.
            thrusters: how many.
            c: coefficients with effects; without them those of the settings.
            effects: `EffectValues` of each thruster, whose tachometers they change; None: none do.
        """
        self._sensors, self._c = sensors, sensor_coefficients(sensors) if c is None else c
        self._streams = streams(sensors, seed, thrusters)
        self._next = {key: self._sensor(key).first for key in self._streams}
        self._waiting: list[tuple[int, Reading]] = []
        self._past: dict[tuple[str, int], deque[Rows]] = {
            key: deque(maxlen=1 + readings_late(key[0], self._sensor(key), self._c)) for key in self._streams
        }
        self._chains: TachometerChains | None = None
        self._told: Any = None
        if effects is not None and sensors.tachometer.rate > 0.0:
            self._chains = TachometerChains(sensors.tachometer, effects, seed)
        self._next_step = self._chains.step if self._chains else 0

    def _sensor(self, key: tuple[str, int]) -> Sensor:
        sensor: Sensor = getattr(self._sensors, key[0])
        return sensor

    @property
    def tick(self) -> int:
        """The longest time whose multiples hold all instants of all sensors [ns]; 0 without any sensor."""
        instants = [each for key in self._streams for each in (self._sensor(key).first, self._sensor(key).period)]
        return gcd(*instants, self._chains.step if self._chains else 0)

    @property
    def next_instant(self) -> int | None:
        """When the truth is asked for next [ns], None without any sensor."""
        return min((*self._next.values(), *([self._next_step] if self._chains else [])), default=None)

    def read(self, now: int, truth: Truth) -> tuple[Reading, ...]:
        """Return the readings that are there at `now` [ns] and were not before, by arrival.

        Args:
            now: an instant after those of former calls, none of a sensor's left out between.
            truth: the true states at `now`.

        Raises:
            ValueError: an instant of a sensor was left out.
        """
        if self._chains is not None and self._next_step <= now:
            self._check("tachometer", self._next_step, now)
            self._next_step += self._chains.step
            self._told = self._chains.told(*(getattr(truth, name) for name in SENSED_BY_TACHOMETERS))
        due = [key for key, instant in self._next.items() if instant <= now]
        if due:
            rows = rows_of(truth, None, self._told)
            for key in due:
                self._take(key, now, rows)
        arrived = [reading for at, reading in self._waiting if at <= now]
        if arrived:
            self._waiting = [each for each in self._waiting if each[0] > now]
        return tuple(arrived)

    def _take(self, key: tuple[str, int], now: int, rows: Rows) -> None:
        name, thruster = key
        sensor, instant = self._sensor(key), self._next[key]
        self._check(name, instant, now)
        self._next[key] = instant + sensor.period
        self._past[key].append(rows)
        values = measured_rows(name, thruster, self._past[key][0], self._c, self._streams[key].next()[None])[0]
        stamp, at = stamp_and_arrival(name, sensor, instant, self._c)
        self._waiting.append((int(at), Reading(name, thruster, int(stamp), instant, tuple(values.tolist()))))
        self._waiting.sort(key=lambda each: each[0])

    def _check(self, name: str, instant: int, now: int) -> None:
        if instant != now:
            raise ValueError(
                f"{name}: expected to be read at {1e-9 * instant:.9g} s; found {1e-9 * now:.9g} s: advance the vehicle "
                f"by {1e-9 * self.tick:g} s or a part of it"
            )
