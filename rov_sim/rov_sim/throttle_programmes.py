"""Throttle programmes for bench experiments: commands [V] at a fixed period, zero at both ends."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["multisine", "ramp_and_hold", "staircase", "with_rest"]

Array = NDArray[np.float64]


def with_rest(commands: Array, period: float, before: float, after: float) -> Array:
    """Return the commands with rest (zero throttle) of `before` and `after` [s] around them."""
    return np.concatenate((np.zeros(round(before / period)), commands, np.zeros(round(after / period))))


def ramp_and_hold(level: float, period: float, *, ramp: float = 2.0, hold: float = 8.0) -> Array:
    """Return the thesis' identification input (4.1.2): a ramp to `level` [V] over `ramp` [s], held for `hold` [s]."""
    rising = level * np.arange(round(ramp / period)) * period / ramp
    return np.concatenate((rising, np.full(round(hold / period), level)))


def staircase(levels: list[float], period: float, *, hold: float) -> Array:
    """Return steps through `levels` [V], each held for `hold` [s]."""
    return np.repeat(np.asarray(levels, dtype=np.float64), round(hold / period))


def multisine(
    amplitude: float, period: float, *, duration: float, lowest: float, highest: float, rng: np.random.Generator
) -> Array:
    """Return a random-phase multisine with 12 log-spaced lines from `lowest` to `highest` [Hz], peak `amplitude` [V].

    Frequencies are rounded to whole numbers of cycles, so that each line is orthogonal to the others.
    """
    time = np.arange(round(duration / period)) * period
    cycles = np.unique(np.round(np.geomspace(lowest, highest, 12) * duration))
    phases = rng.uniform(0.0, 2.0 * np.pi, cycles.size)
    signal = np.sum(np.sin(2.0 * np.pi * np.outer(time / duration, cycles) + phases), axis=1)
    return np.asarray(amplitude * signal / np.max(np.abs(signal)))
