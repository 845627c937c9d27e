"""From the load cell's axes to the thruster's.

The load cell's frame b is turned a quarter about z against the thruster's frame t: x_t = -y_b, y_t = x_b, z_t
= z_b. Forces are those of the thruster: thrust T = x_t . F = -F_y. Moments are published as counter-moments,
-R M, so that the torque about the shaft is Q = +M_y, positive for forward rotation.

A fixture that was turned round is undone by half a turn about z_t: x and y of force and torque change their
sign.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .signals import smooth

Array = NDArray[np.float64]
B_TO_T = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
HALF_TURN = np.array([-1.0, -1.0, 1.0])
BLOCK = 0.5  # [s]
LEAST_SPEED = 50.0  # [rad/s]
STANDARD_ERRORS = 5.0
LEAST_THRUST = 1.0  # [N] at more than 50 rad/s; less is air, and tells no direction
LEAST_BLOCKS = 3


def to_thruster(force: Array, moment: Array, *, reversed_fixture: bool) -> tuple[Array, Array]:
    """Return force [N] and torque [N m] in the thruster's frame, each (N, 3)."""
    turn = HALF_TURN if reversed_fixture else np.ones(3)
    return force @ B_TO_T.T * turn, -moment @ B_TO_T.T * turn


def forward_thrust(time: Array, thrust: Array, rest: float, direction: Array) -> tuple[float, float] | None:
    """Return mean and standard error [N] of the thrust above rest in the direction of rotation.

    Args:
        time: [s] (N,).
        thrust: as recorded [N] (N,).
        rest: thrust at rest [N].
        direction: +1, -1, or 0 where it does not count (too slow), (N,).

    Returns:
        None with less than three blocks of half a second to take the scatter from.
    """
    block = np.floor((time - time[0]) / BLOCK).astype(np.int64)
    counts = np.bincount(block, weights=(direction != 0).astype(float))
    sums = np.bincount(block, weights=(thrust - rest) * direction)
    full = counts > 0.9 * np.max(np.bincount(block))
    means = sums[full] / counts[full]
    if len(means) < LEAST_BLOCKS:
        return None
    return float(np.mean(means)), float(np.std(means, ddof=1) / np.sqrt(len(means)))


def turns(time: Array, speed: Array, sign: Array) -> Array:
    """Return the direction of rotation where it is faster than 50 rad/s, else 0."""
    return np.where(smooth(np.abs(speed), time, 0.1) > LEAST_SPEED, sign, 0.0)
