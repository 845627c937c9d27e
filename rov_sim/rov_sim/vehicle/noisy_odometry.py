"""Odometry that is the truth with Gaussian noise: what a study feeds back where it leaves the sensors out.

attitude q * exp(e / 2), e in body axes [rad];    velocity nu + e [m/s, rad/s];    a draw each period, from one stream
"""

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.compilation import equation
from thruster_model.equations.attitude import quaternion_product
from thruster_model.equations.rotation_vector import rotation

__all__ = ["COLUMNS", "OdometryErrors", "OdometryNoise", "odometry_with"]

Array = NDArray[np.float64]
COLUMNS = 9
"""Of an error: attitude [rad], velocity [m/s], rates [rad/s], three each."""
_STREAM = (1000,)  # beside those of the sensors


class OdometryNoise(NamedTuple):
    """Standard deviations of each axis and period: attitude [rad], velocity [m/s], rate [rad/s]."""

    attitude: float = 0.0
    velocity: float = 0.0
    rate: float = 0.0


class OdometryErrors:
    """The errors of one run, period by period or many at once: the same numbers."""

    def __init__(self, noise: OdometryNoise, seed: int) -> None:
        """Begin the stream of the run `seed`; ValueError for deviations that cannot be."""
        wrong = [f"{name}: {x!r}" for name, x in noise._asdict().items() if not (isfinite(x) and x >= 0.0)]
        if wrong:
            raise ValueError(f"odometry noise: expected finite numbers, 0 or more; found {', '.join(wrong)}")
        self._sizes = np.repeat([noise.attitude, noise.velocity, noise.rate], 3)
        self._rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=_STREAM))

    def take(self, count: int) -> Array:
        """Return the errors of the next periods, (count, COLUMNS)."""
        return np.asarray(self._sizes * self._rng.standard_normal((count, COLUMNS)))


@equation
def odometry_with(attitude, velocity, e, told_attitude, told_velocity):  # type: ignore[no-untyped-def]
    """Fill told_attitude (4,) and told_velocity (6,) with attitude q (4,), velocity nu (6,) and errors e (COLUMNS,)."""
    q = (attitude[0], attitude[1], attitude[2], attitude[3])
    turned = quaternion_product(q, rotation((e[0], e[1], e[2])))
    told_attitude[0], told_attitude[1], told_attitude[2], told_attitude[3] = turned
    for i in range(6):
        told_velocity[i] = velocity[i] + e[3 + i]
