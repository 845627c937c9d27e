"""A random wrench on the body, which limits how well its motion can be predicted: eddies, a tether's pull.

It wanders (`wandering`); the value at the beginning of a period acts throughout it.
"""

from dataclasses import dataclass
from math import exp, inf, isfinite

import numpy as np
from numpy.typing import NDArray

from rov_sim.wandering import wandering

__all__ = ["RandomWrench", "WrenchStream"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class RandomWrench:
    """Sizes and time constant.

    Attributes:
        size: standard deviations of the force [N] and moment [N m] on the body at its origin, x, y, z each.
        time: correlation time [s]; 0: every period anew.
    """

    size: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    time: float = 3.0

    def __post_init__(self) -> None:
        wrong = []
        if len(self.size) != 6 or not all(isfinite(s) and s >= 0.0 for s in self.size):
            wrong.append(f"size: expected six finite numbers, 0 or more; found {self.size!r}")
        if not 0.0 <= self.time < inf:
            wrong.append(f"time: expected a finite number of seconds, 0 or more; found {self.time!r}")
        if wrong:
            raise ValueError("random wrench: " + "; ".join(wrong))

    def series(self, count: int, period: float, seed: int) -> Array:
        """Return the wrenches of `count` periods of `period` [s], shape (count, 6) [N, N m]."""
        return WrenchStream(self, period, seed).take(count)


class WrenchStream:
    """The same wrenches period by period."""

    def __init__(self, wrench: RandomWrench, period: float, seed: int) -> None:
        """Begin with periods of `period` [s]; a stream of its own of the run `seed`."""
        self._rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(_STREAM,)))
        self._size = np.asarray(wrench.size, dtype=np.float64)
        self._keep = exp(-period / wrench.time) if wrench.time > 0.0 else 0.0
        self._now: Array | None = None

    def take(self, count: int) -> Array:
        """Return the wrenches of the next periods, shape (count, 6) [N, N m]."""
        out = wandering(self._rng.standard_normal((count, 6)), self._size, self._keep, self._now)
        self._now = out[-1] if count else self._now
        return out


_STREAM = 1000
"""Beside those of the sensors."""
