"""The structure that carries the thruster, as a linear model with the thrust as an unknown input.

    q' = r + w d,    r' = w^2 (T - q) - 2 zeta w r,    w = 2 pi f,    T' = white (random walk),    d = white
    y_F   = q + p_F + e_F                                       the force that the load cell reads along the thruster
    y_M/a = g (T + rho (q - T)) + b + p_M + e_M                 the moment across it, over its lever arm a

At rest y_F = T and y_M = a T. d excites the mode (the motor's reaction, the propeller) but has no lasting mean, or it
would be thrust. The mode rings strongly in the force (all of q - T) and weakly in the moment (the share
rho), so that two channels separate thrust from ringing; neither can alone without knowing how thrust behaves. g is
the arm's correction, b the part of the moment that has nothing to do with thrust (slow). The joints soften with
amplitude: f = f_1 - s log10(A / 1 N), A [N] being the envelope of the force around the mode. p stands for what else
vibrates at higher frequencies (further modes, the propeller's blades), whatever drives it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thruster_model.load_cell.smoothing import LinearModel

__all__ = ["MEAN", "THRUST", "Mode", "Noise", "Stretch", "linear_model"]

Array = NDArray[np.float64]
LEAST_AMPLITUDE = 0.3  # [N] below it the frequency stays: the envelope is noise
LEAST_LEVEL = 0.02
THRUST, MEAN = 2, 8
"""Indices of the thrust, and of its mean over the cell that just ended, in the state."""


@dataclass(frozen=True, kw_only=True)
class Mode:
    """The mode that the thrust excites.

    Attributes:
        frequency: at an amplitude of 1 N [Hz].
        softening: what the frequency loses per decade of amplitude [Hz].
        damping: ratio [1].
        leak: share of the ringing that the moment shows, rho [1].
        arm_gain: correction of the lever arm, g [1].
    """

    frequency: float
    softening: float
    damping: float
    leak: float
    arm_gain: float

    def at(self, amplitude: Array) -> Array:
        """Return the frequency [Hz] at amplitudes [N]."""
        decades = np.log10(np.maximum(amplitude, LEAST_AMPLITUDE))
        return np.asarray(np.maximum(self.frequency - self.softening * decades, 0.3 * self.frequency))


@dataclass(frozen=True, kw_only=True)
class Noise:
    """What is random; all but the last two at full speed of the propeller.

    Attributes:
        walk: of the thrust [N/sqrt(s)].
        jump_walk: of the thrust, for each volt that the throttle has just jumped by [N/sqrt(s)/V].
        bias_walk: of b [N/sqrt(s)].
        drive: density of the forces other than thrust that excite the mode [N/sqrt(Hz)].
        jump_drive: the same, for each volt that the throttle has just jumped by [N/sqrt(Hz)/V]: the motor's reaction.
        mismatch: the same, for each newton of ringing [1/sqrt(Hz)]: the mode is not quite linear.
        force_vibration, moment_vibration: standard deviations of p_F, p_M [N].
        force_frequency, moment_frequency: of p_F, p_M [Hz].
        vibration_damping: of both [1].
        force_reading, moment_reading: standard deviations of e_F, e_M, one sample [N].
    """

    walk: float
    jump_walk: float
    bias_walk: float
    drive: float
    jump_drive: float
    mismatch: float
    force_vibration: float
    moment_vibration: float
    force_frequency: float
    moment_frequency: float
    vibration_damping: float
    force_reading: float
    moment_reading: float


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """Part of a recording.

    Attributes:
        name: of the recording.
        time: evenly spaced [s] (N,).
        reading: force, and moment over its arm [N] (N, 2); NaN where missing.
        amplitude: envelope of the force around the mode [N] (N,).
        level: of vibration, 1 at full speed and 0 at rest (N,).
        jump: by how much the throttle has just jumped [V] (N,).
    """

    name: str
    time: Array
    reading: Array
    amplitude: Array
    level: Array
    jump: Array

    def part(self, start: float, end: float) -> "Stretch":
        """Return the part with start <= time < end [s]."""
        k = (self.time >= start - 1e-9) & (self.time < end - 1e-9)
        return Stretch(
            name=self.name, time=self.time[k], reading=self.reading[k], amplitude=self.amplitude[k],
            level=self.level[k], jump=self.jump[k],
        )  # fmt: skip


def _oscillator(frequency: Array, damping: float, dt: float) -> tuple[Array, Array]:
    """Return the exact transition (N, 2, 2) of an oscillator's (q, q') and its response (N, 2) to a held force."""
    w = 2.0 * np.pi * frequency
    zeta = min(damping, 0.999)
    wd = w * np.sqrt(1.0 - zeta**2)
    decay, c, s = np.exp(-zeta * w * dt), np.cos(wd * dt), np.sin(wd * dt)
    A = np.empty((w.size, 2, 2))
    A[:, 0, 0] = decay * (c + zeta * w / wd * s)
    A[:, 0, 1] = decay * s / wd
    A[:, 1, 0] = -decay * w**2 / wd * s
    A[:, 1, 1] = decay * (c - zeta * w / wd * s)
    return A, np.stack([1.0 - A[:, 0, 0], -A[:, 1, 0]], axis=1)


def linear_model(stretch: Stretch, mode: Mode, noise: Noise, *, cell: int = 0) -> LinearModel:
    """Return the matrices for a stretch; the state is (q, r, T, b, p_F, p_F', p_M, p_M').

    With `cell` samples there is a ninth state, which at sample j * cell is the mean of T over the cell before.
    """
    dt = float(stretch.time[1] - stretch.time[0])
    N = stretch.time.size
    level = np.maximum(stretch.level, LEAST_LEVEL)
    frequency = mode.at(stretch.amplitude)
    F, Q = np.zeros((N, 8, 8)), np.zeros((N, 8, 8))
    F[:, :2, :2], F[:, :2, 2] = _oscillator(frequency, mode.damping, dt)
    F[:, 2, 2] = F[:, 3, 3] = 1.0
    drive = (noise.drive * level) ** 2 + (noise.jump_drive * stretch.jump) ** 2
    drive += (noise.mismatch * np.maximum(stretch.amplitude - 1.0, 0.0)) ** 2
    Q[:, 0, 0] = (2 * np.pi * frequency) ** 2 * drive * dt
    Q[:, 2, 2] = ((noise.walk * level) ** 2 + (noise.jump_walk * stretch.jump) ** 2) * dt
    Q[:, 3, 3] = (noise.bias_walk * level) ** 2 * dt
    start = stretch.reading[: max(1, round(0.1 / dt))]
    first = np.array([np.mean(known) if (known := c[np.isfinite(c)]).size else 0.0 for c in start.T])
    mean = np.array([first[0], 0.0, first[0], first[1] - first[0], 0.0, 0.0, 0.0, 0.0])
    spread = [2.0, 4.0 * np.pi * mode.frequency, 2.0, 3.0]
    vibrations = ((noise.force_vibration, noise.force_frequency), (noise.moment_vibration, noise.moment_frequency))
    for i, (deviation, f) in zip((4, 6), vibrations, strict=True):
        w = 2 * np.pi * f
        F[:, i : i + 2, i : i + 2] = _oscillator(np.full(1, f), noise.vibration_damping, dt)[0]
        # White noise of intensity 4 zeta w^3 sigma^2 makes an oscillator's standard deviation sigma.
        Q[:, i + 1, i + 1] = 4 * noise.vibration_damping * w**3 * (deviation * level) ** 2 * dt
        spread += [deviation, deviation * w]
    H = np.zeros((2, 8))
    H[0, 0] = H[0, 4] = 1.0
    H[1, 0], H[1, 2] = mode.arm_gain * mode.leak, mode.arm_gain * (1.0 - mode.leak)
    H[1, 3] = H[1, 6] = 1.0
    if cell:
        F, Q, H = (np.pad(m, [(0, 0)] * (m.ndim - 2) + [(0, k), (0, 1)]) for m, k in ((F, 1), (Q, 1), (H, 0)))
        F[:, MEAN, MEAN] = np.where(np.arange(N) % cell == 0, 0.0, 1.0)
        F[:, MEAN, THRUST] = 1.0 / cell
        Q[:, MEAN, MEAN] = 1e-8  # [N^2] keeps covariances regular
        mean, spread = np.append(mean, 0.0), [*spread, 1e-3]
    R = np.array([noise.force_reading, noise.moment_reading]) ** 2
    return LinearModel(F=F, Q=Q, H=H, R=R, mean=mean, covariance=np.diag(np.square(spread)))
