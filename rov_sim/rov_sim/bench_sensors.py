"""Sensors of a thruster bench: what they make of the true values. All take their random generator as an argument."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import cont2discrete, lfilter

__all__ = ["LoadCell", "Tachometer", "Velocimeter"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Tachometer:
    """An unsigned tachometer behind an analogue-digital converter.

    Attributes:
        scale: rotor speed per volt [rad/s/V].
        offset: reading at rest [V].
        noise: standard deviation of a sample [V].
        resolution: of the converter [V].
    """

    scale: float = 49.9723
    offset: float = 0.023
    noise: float = 0.02
    resolution: float = 0.001

    def read(self, speed: Array, rng: np.random.Generator) -> Array:
        """Return the magnitude of the speed as read [rad/s], shape of `speed`."""
        volts = np.abs(speed) / self.scale + self.offset + self.noise * rng.standard_normal(speed.shape)
        return self.scale * self.resolution * np.round(volts / self.resolution)


@dataclass(frozen=True, kw_only=True)
class LoadCell:
    """A load cell on a springy structure: it rings after jumps, drifts a little and rests at some value.

    Attributes:
        frequency: of the structure's mode [Hz].
        damping: of that mode, as a fraction of critical.
        noise: standard deviation of a sample at the sampling rate [N or N m].
        rest: reading at rest [N or N m].
        drift: rate of the reading [N/s or N m/s].
    """

    frequency: float = 7.0
    damping: float = 0.04
    noise: float = 0.5
    rest: float = 0.0
    drift: float = 0.0

    def read(self, load: Array, dt: float, rng: np.random.Generator) -> Array:
        """Return the reading [N or N m] of a load sampled every `dt` [s], shape (N,)."""
        omega = 2.0 * np.pi * self.frequency
        mode = ([omega**2], [1.0, 2.0 * self.damping * omega, omega**2])
        numerator, denominator, _ = cont2discrete(mode, dt, method="bilinear")
        ringing = lfilter(numerator.ravel(), denominator, load)
        time = dt * np.arange(load.size)
        return np.asarray(ringing + self.rest + self.drift * time + self.noise * rng.standard_normal(load.shape))


@dataclass(frozen=True, kw_only=True)
class Velocimeter:
    """An acoustic Doppler velocimeter in turbulent flow: noise, turbulence that remembers, and spikes.

    Attributes:
        rate: of the samples [Hz].
        noise: standard deviation of a sample [m/s].
        turbulence: standard deviation of the turbulence as a fraction of the velocity.
        memory: its correlation time [s].
        spike_share: share of samples that are spikes.
        spike_size: standard deviation of a spike [m/s].
    """

    rate: float = 25.0
    noise: float = 0.008
    turbulence: float = 0.08
    memory: float = 0.2
    spike_share: float = 0.05
    spike_size: float = 0.3

    def read(self, velocity: Array, dt: float, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return (instants [s], readings [m/s]) of a velocity [m/s] given every `dt` [s] from time 0."""
        every = 1.0 / self.rate
        time = np.arange(0.0, (velocity.size - 1) * dt, every)
        true = np.interp(time, dt * np.arange(velocity.size), velocity)
        keep = np.exp(-every / self.memory)
        eddies = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.standard_normal(time.size))
        spikes = np.where(rng.random(time.size) < self.spike_share, self.spike_size, 0.0)
        noise = self.noise * rng.standard_normal(time.size) + spikes * rng.standard_normal(time.size)
        return time, np.asarray(true * (1.0 + self.turbulence * eddies) + noise)
