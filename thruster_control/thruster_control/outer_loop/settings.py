"""Settings of the outer loops: one class for each law, which decides on the equations when a kernel is compiled.

All are tuples of arrays and floats, so that kernels take them as they are; made and checked by the functions below.
"""

from math import inf, pi
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "EulerLaw", "LinearLaw", "OuterMemory", "PidLaw", "QuaternionLaw", "VehicleSetPoint", "euler_law", "outer_memory",
    "pid_law", "quaternion_law",
]  # fmt: skip

Array = NDArray[np.float64]
Vector = tuple[float, float, float]


class VehicleSetPoint(NamedTuple):
    """Where the vehicle shall point and how fast it shall move, as thruster_msgs/VehicleSetpoint; NaN: nowhere.

    attitude, its rate and acceleration: roll, pitch, yaw and their time derivatives [rad, rad/s, rad/s^2];
    velocity, acceleration: surge, sway, heave [m/s, m/s^2].
    """

    attitude: Vector = (0.0, 0.0, 0.0)
    attitude_rate: Vector = (0.0, 0.0, 0.0)
    attitude_acceleration: Vector = (0.0, 0.0, 0.0)
    velocity: Vector = (0.0, 0.0, 0.0)
    acceleration: Vector = (0.0, 0.0, 0.0)


class QuaternionLaw(NamedTuple):
    """(2.22) with the error of attitude as a quaternion: the same at every attitude.

    K_P (6, 6) [1/s], positive definite; k_I [1/s^2]; hysteresis: cosine of half the angle beyond half a turn from
    which the other way round is taken (0.1: 11.5 degrees beyond).
    """

    K_P: Array
    k_I: float
    hysteresis: float


class EulerLaw(NamedTuple):
    """(2.22) as the thesis writes it, with Euler angles, for reproduction.

    K_P (6, 6) [1/s], k_I [1/s^2]; steepest: |pitch| [rad] beyond which J_2 is that at this pitch: it has no bound.
    """

    K_P: Array
    k_I: float
    steepest: float


class LinearLaw(NamedTuple):
    """(2.22) made linear at rest: constant matrices, a PD law with constant feed-forward.

    K_P (6, 6) [1/s], k_I [1/s^2]; M (6, 6); D_L (6, 6); level (6,): g at rest [N, N m]; slope (6, 3): its slope over
    roll, pitch, yaw [N/rad, N m/rad].
    """

    K_P: Array
    k_I: float
    M: Array
    D_L: Array
    level: Array
    slope: Array


class PidLaw(NamedTuple):
    """A PID for each axis, which knows nothing of the vehicle.

    On surge, sway, heave the error is one of speed, on the others of angle [m/s, rad]. proportional (6,), integral
    (6,): per unit of error, and of its integral over time; derivative (3,): of the angles [N m s]; largest (6,): of the
    wrench [N, N m].
    """

    proportional: Array
    integral: Array
    derivative: Array
    largest: Array
    hysteresis: float


class OuterMemory(NamedTuple):
    """What a loop remembers, changed in place.

    integral (6,): of a PID [m, rad s]; shortfall (6,): what the thrusters fell short of in the last step [N, N m], for
    its anti-windup (`step.note_achieved`); error (4,): the error of attitude as a quaternion, zeros at first; the
    others are room to compute in.
    """

    integral: Array
    shortfall: Array
    error: Array
    known: Array
    terms: Array
    wanted: Array


def outer_memory() -> OuterMemory:
    """Return the memory before the first step; each loop needs its own."""
    return OuterMemory(*(np.zeros(size) for size in (6, 6, 4, 6, 6, 6)))


def _gain(K_P: ArrayLike, k_I: float, wrong: list[str]) -> Array:
    """Return K_P as a matrix; it may be given as its diagonal, or as one number."""
    gain = np.asarray(K_P, dtype=np.float64)
    gain = np.diag(np.broadcast_to(gain, (6,))) if gain.shape in ((), (6,)) else gain
    symmetric = gain.shape == (6, 6) and np.all(np.isfinite(gain)) and np.allclose(gain, gain.T, rtol=1e-9, atol=1e-12)
    if not symmetric or np.linalg.eigvalsh(gain)[0] <= 0.0:
        wrong.append(
            f"K_P: expected a symmetric positive definite matrix (6, 6), or its diagonal; found {gain.tolist()}"
        )
    if not 0.0 <= k_I < inf:
        wrong.append(f"k_I: expected a finite number, 0 or more; found {k_I}")
    return np.array(gain)


def _raise(law: str, wrong: list[str]) -> None:
    if wrong:
        raise ValueError(f"{law}: " + "; ".join(wrong))


def quaternion_law(K_P: ArrayLike, k_I: float, *, hysteresis: float = 0.1) -> QuaternionLaw:
    """Return the checked law; `K_P` is a matrix (6, 6), its diagonal or one number [1/s].

    Raises:
        ValueError: with all that is wrong.
    """
    wrong: list[str] = []
    gain = _gain(K_P, k_I, wrong)
    if not 0.0 <= hysteresis < 1.0:
        wrong.append(f"hysteresis: expected a number from 0 to below 1; found {hysteresis}")
    _raise("quaternion law", wrong)
    return QuaternionLaw(gain, float(k_I), float(hysteresis))


def euler_law(K_P: ArrayLike, k_I: float, *, steepest_deg: float = 80.0) -> EulerLaw:
    """Return the checked law; the same gains."""
    wrong: list[str] = []
    gain = _gain(K_P, k_I, wrong)
    if not 0.0 < steepest_deg < 90.0:
        wrong.append(f"steepest_deg: expected an angle above 0 and below 90 degrees; found {steepest_deg}")
    _raise("Euler law", wrong)
    return EulerLaw(gain, float(k_I), steepest_deg * pi / 180.0)


def pid_law(
    proportional: ArrayLike, integral: ArrayLike, derivative: ArrayLike, largest: ArrayLike, *, hysteresis: float = 0.1
) -> PidLaw:
    """Return the checked law; gains are numbers for each axis, or one for all."""
    wrong: list[str] = []
    given = {"proportional": (proportional, 6), "integral": (integral, 6), "derivative": (derivative, 3)}
    arrays: list[Any] = []
    for name, (values, size) in {**given, "largest": (largest, 6)}.items():
        try:
            array = np.array(np.broadcast_to(np.asarray(values, dtype=np.float64), (size,)))
        except ValueError:
            wrong.append(f"{name}: expected {size} numbers; found {values!r}")
            continue
        arrays.append(array)
        if not np.all((array >= 0.0) & (array < inf)):
            wrong.append(f"{name}: expected finite numbers, 0 or more; found {array}")
    if not 0.0 <= hysteresis < 1.0:
        wrong.append(f"hysteresis: expected a number from 0 to below 1; found {hysteresis}")
    _raise("PID law", wrong)
    by_error, by_integral, by_rate, most = arrays
    return PidLaw(by_error, by_integral, by_rate, most, float(hysteresis))
