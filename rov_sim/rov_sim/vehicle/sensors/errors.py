"""The random errors of sensors: one stream for each, so that no sensor's errors depend on another's.

error_k = bias + noise z_k,    bias drawn once in a run;    NaN in all columns: the reading holds nothing

A reading is lost at random: after a good one with probability s / (L (1 - s)), after a lost one with 1 - 1/L, for a
share s of all readings in runs of L in the mean. Each reading takes as many normal numbers from its stream as it has
columns and one more for that, lost or not: errors come out the same whether they are taken one by one or at once, and
a sensor that loses readings has the same noise in those that are left.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from rov_sim.vehicle.sensors.settings import QUANTITIES, Sensor, VehicleSensors

__all__ = ["ErrorStream", "count_until", "drawn_errors", "streams"]

Array = NDArray[np.float64]
_CHUNK = 64


class ErrorStream:
    """The errors of one sensor, reading by reading."""

    def __init__(self, sensor: Sensor, seed: int, key: tuple[int, ...]) -> None:
        """Begin the stream `key` of the run `seed`."""
        self._rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
        self._noise = np.asarray(sensor.noise)
        self._bias = np.asarray(sensor.bias) + np.asarray(sensor.bias_deviation) * self._rng.standard_normal(
            self._noise.size
        )
        share, length = sensor.lost_share, sensor.lost_length
        # of losing a reading: the first one, after a good one, after a lost one; as limits of normal numbers
        after_good = share / (length * (1.0 - share))
        self._limits = tuple(float(ndtri(p)) for p in (share, after_good, 1.0 - 1.0 / length))
        self._state = 0
        self._kept = np.empty((0, self._noise.size))

    @property
    def bias(self) -> Array:
        """The bias of this run, shape (columns,)."""
        return self._bias.copy()

    def take(self, count: int) -> Array:
        """Return the next errors, shape (count, columns); NaN: lost."""
        z = self._rng.standard_normal((count, self._noise.size + 1))
        errors = self._bias + self._noise * z[:, :-1]
        for k, draw in enumerate(z[:, -1]):
            lost = bool(draw < self._limits[self._state])
            self._state = 2 if lost else 1
            if lost:
                errors[k] = np.nan
        return errors

    def next(self) -> Array:
        """Return the errors of the next reading, shape (columns,)."""
        if not len(self._kept):
            self._kept = self.take(_CHUNK)
        errors, self._kept = self._kept[0], self._kept[1:]
        return errors


def streams(sensors: VehicleSensors, seed: int, thrusters: int) -> dict[tuple[str, int], ErrorStream]:
    """Return the streams of all sensors that are there, by name and index of the thruster; -1: of the vehicle."""
    found = {}
    for index, name in enumerate(QUANTITIES):
        if name in sensors.there():
            for i in range(thrusters) if name == "tachometer" else (-1,):
                found[name, i] = ErrorStream(getattr(sensors, name), seed, (index, i + 1))
    return found


def count_until(sensor: Sensor, end: int) -> int:
    """Return how many readings a sensor takes until `end` [ns], included."""
    return max(0, (end - sensor.first) // sensor.period + 1)


def drawn_errors(sensors: VehicleSensors, seed: int, thrusters: int, end: int) -> Mapping[tuple[str, int], Array]:
    """Return the errors of all readings until `end` [ns], by sensor as in `streams`, shape (readings, columns) each."""
    return {
        (name, i): stream.take(count_until(getattr(sensors, name), end))
        for (name, i), stream in streams(sensors, seed, thrusters).items()
    }
