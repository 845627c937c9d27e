"""What an observer believes about one thruster, what a measurement said to it, and what both are worth.

`Belief` and `Innovation` are named tuples of numbers, so that kernels pass them on. The status is a set of flags: one
step can use the tachometer and refuse the velocimeter. `level` and `reason` put it into words.
"""

from enum import IntEnum, IntFlag
from math import inf, sqrt
from typing import NamedTuple

from thruster_estimation.matrices import Covariance

__all__ = [
    "Belief", "Innovation", "Level", "Status", "covariance_of", "deviations", "in_numbers", "initial_belief", "level",
    "reason",
]  # fmt: skip


class Status(IntFlag):
    """What the last step did, and what limits the estimate."""

    INITIAL = 0
    USED_N = 1
    USED_U = 2
    GATED_N = 4
    GATED_U = 8
    AMBIGUOUS = 16
    REOPENED = 32
    CEILING = 64
    STALE_N = 128
    STALE_U = 256
    NO_THROTTLE = 512
    BAD_PERIOD = 1024
    NO_COVARIANCE = 2048
    RESTARTED = 4096
    PREDICTED = 8192
    IMPLAUSIBLE_N = 16384
    IMPLAUSIBLE_U = 32768


class Level(IntEnum):
    """Whether an estimate is to be used; the numbers of thruster_msgs/ThrusterEstimate."""

    OK = 0
    DEGRADED = 1
    INVALID = 2


_WORDS = {
    Status.GATED_N: "the speed measured is too unlikely and was refused",
    Status.GATED_U: "the ambient flow measured is too unlikely and was refused",
    Status.AMBIGUOUS: "unsigned speed within its deviation of zero: used with raised noise",
    Status.REOPENED: "a measurement refused for long was used after the covariance had been widened",
    Status.CEILING: "a deviation is at its ceiling: the measurements hardly tell that state",
    Status.STALE_N: "no speed was used for too long",
    Status.STALE_U: "no ambient flow was used for too long",
    Status.NO_THROTTLE: "throttle not known: the speed was held and its deviation widened",
    Status.BAD_PERIOD: "the period was no finite time >= 0: nothing was predicted",
    Status.IMPLAUSIBLE_N: "the speed measured is one that no thruster has and was refused",
    Status.IMPLAUSIBLE_U: "the ambient flow measured is one that no thruster meets and was refused",
    Status.RESTARTED: "the estimate left the numbers and was started again with the largest deviations",
}
_INVALID = Status.STALE_N | Status.RESTARTED | Status.BAD_PERIOD


class Belief(NamedTuple):
    """States n [rad/s], v, U [m/s] with their covariance, the status, and the ages of what was measured.

    Attributes:
        n, v, U: rotor speed, axial flow, ambient flow.
        P_nn ... P_UU: covariance [rad^2/s^2, rad m/s^2, m^2/s^2]; never NaN. Infinite P_vv and P_UU with zero
            covariances: the observer computes none for v and U (status NO_COVARIANCE). No start for one that does.
        status: flags of `Status`.
        unseen_n, unseen_U: time since the last measurement that was used [s].
        shut_n, shut_U: for how long measurements have been refused in a row [s]; missing ones do not count.
    """

    n: float
    v: float
    U: float
    P_nn: float
    P_nv: float
    P_nU: float
    P_vv: float
    P_vU: float
    P_UU: float
    status: int = 0
    unseen_n: float = 0.0
    unseen_U: float = 0.0
    shut_n: float = 0.0
    shut_U: float = 0.0


class Innovation(NamedTuple):
    """What a step's measurements said to its prediction; NaN where one was missing or unusable.

    Attributes:
        y_n: measured less predicted speed [rad/s]; the unsigned one with the sign of the prediction.
        y_U: measured less predicted ambient flow [m/s].
        S_nn, S_nU, S_UU: covariance of the two; NaN where the observer has none.
        nis_n, nis_U: each squared over its variance; nis: of the two together, chi-square with `dof` degrees.
        used_n, used_U, gated_n, gated_U: 1 or 0.
    """

    y_n: float
    y_U: float
    S_nn: float
    S_nU: float
    S_UU: float
    nis_n: float
    nis_U: float
    nis: float
    dof: int
    used_n: int
    used_U: int
    gated_n: int
    gated_U: int


def initial_belief(
    n: float = 0.0, v: float = 0.0, U: float = 0.0, *, deviation_n: float, deviation_v: float, deviation_U: float
) -> Belief:
    """Return a belief with independent states: n [rad/s], v, U [m/s] and their deviations in the same units."""
    values = (n, v, U, deviation_n, deviation_v, deviation_U)
    if not all(abs(x) < inf for x in values) or min(values[3:]) < 0:
        raise ValueError(f"initial belief: expected finite states and deviations >= 0, got {values}")
    squares = [float(d) ** 2 for d in values[3:]]
    return Belief(float(n), float(v), float(U), squares[0], 0.0, 0.0, squares[1], 0.0, squares[2])


def in_numbers(belief: Belief) -> Belief:
    """Return the belief with floats and the integer status, as compiled kernels expect them."""
    return Belief(**{k: int(x) if k == "status" else float(x) for k, x in belief._asdict().items()})  # type: ignore[arg-type]


def covariance_of(belief: Belief) -> Covariance:
    """Return the covariance alone."""
    return Covariance(belief.P_nn, belief.P_nv, belief.P_nU, belief.P_vv, belief.P_vU, belief.P_UU)


def deviations(belief: Belief) -> tuple[float, float, float]:
    """Return the standard deviations of n [rad/s], v and U [m/s]; infinite where there is none."""
    return sqrt(belief.P_nn), sqrt(belief.P_vv), sqrt(belief.P_UU)


def level(status: int) -> Level:
    """Return whether an estimate with this status is to be used."""
    flags = Status(int(status))
    if flags == Status.INITIAL or flags & _INVALID:
        return Level.INVALID
    degraded = Status(sum(_WORDS)) & ~_INVALID
    missing = not flags & Status.USED_N
    return Level.DEGRADED if flags & degraded or missing else Level.OK


def reason(status: int) -> str:
    """Return why the level is not OK in words, "" with OK."""
    flags = Status(int(status))
    if flags == Status.INITIAL:
        return "no step taken yet"
    found = [words for flag, words in _WORDS.items() if flags & flag]
    if not flags & (Status.USED_N | Status.GATED_N):
        found.append("no usable speed")
    return "; ".join(found)
