r"""An observer while measurements arrive: its track from one instant to the next, and what to say about it.

At an instant t with |n| or n and perhaps U, and the throttle that acted since the instant before:

proper    the belief is predicted over the time since then and corrected with the measurement of t
bench     the belief for t is what Euler made of the former instant's measurement; that of t waits for the next one,
          and the first belief is the bench's

The first instant, and each that does not lie after the former one, begins anew from what is measured then.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import isinf, nan, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_estimation.belief import Belief, Innovation, Status, covariance_of, initial_belief
from thruster_estimation.first_belief import measured_belief
from thruster_estimation.offline import compiled_step
from thruster_estimation.settings import BENCH, SpeedEkfSettings

__all__ = [
    "LARGEST_FLOW",
    "LARGEST_SPEED",
    "START",
    "Measured",
    "Track",
    "advance",
    "covariance_matrix",
    "first_belief",
    "mean_throttle",
    "plausible",
    "states",
]


LARGEST_SPEED = 2000.0
"""[rad/s] 19,000 rpm: what is measured beyond is no speed of a thruster, whatever an observer's gate would say."""
LARGEST_FLOW = 20.0
"""[m/s] As `LARGEST_SPEED`, of the ambient flow."""


class Measured(NamedTuple):
    """What was measured at an instant [ns]: n [rad/s], a magnitude where `unsigned`, and U [m/s]; NaN: nothing."""

    stamp: int
    n: float
    U: float
    unsigned: bool


class Track(NamedTuple):
    """The belief at the instant of `measured`; None before the first."""

    belief: Belief | None
    innovation: Innovation | None
    measured: Measured | None


START = Track(None, None, None)


def plausible(
    measured: Measured, largest_speed: float = LARGEST_SPEED, largest_flow: float = LARGEST_FLOW
) -> tuple[Measured, Status]:
    """Return what was measured without readings that no thruster can give, and which of them there were."""
    flags = Status.INITIAL
    if abs(measured.n) > largest_speed:
        measured, flags = measured._replace(n=nan), flags | Status.IMPLAUSIBLE_N
    if abs(measured.U) > largest_flow:
        measured, flags = measured._replace(U=nan), flags | Status.IMPLAUSIBLE_U
    return measured, flags


def first_belief(n: float, U: float, u: float, unsigned: bool, form: int) -> Belief:
    """Return the belief before the first measurement: the bench's, or the measurement with wide deviations.

    n [rad/s] and U [m/s] as measured, NaN: not; u: throttle before [V], whose sign an unsigned speed gets.
    """
    if form == BENCH:
        return initial_belief(deviation_n=sqrt(3.0), deviation_v=sqrt(0.005), deviation_U=sqrt(0.005))
    return measured_belief(float(n), float(U), float(u), unsigned)  # type: ignore[no-any-return]


def advance(track: Track, measured: Measured, u: float, settings: Any, p: Any) -> Track:
    """Return the track at the instant of `measured`.

    Args:
        track: at the former instant, `START` at first.
        measured: at this one.
        u: throttle that acted since the former instant [V], NaN: not known.
        settings: `checked` ones of an observer.
        p: `ThrusterCoefficients`.
    """
    former = track.measured
    settings = settings._replace(unsigned=int(measured.unsigned))
    if track.belief is None or former is None or measured.stamp <= former.stamp:
        belief = first_belief(measured.n, measured.U, u, measured.unsigned, settings.form)
        if settings.form == BENCH:
            return Track(belief, None, measured)
        belief, innovation = compiled_step(belief, measured.n, measured.U, 0.0, u, settings, p)
        return Track(belief, innovation, measured)
    dt = (measured.stamp - former.stamp) / 1e9
    y = former if settings.form == BENCH else measured
    belief, innovation = compiled_step(track.belief, y.n, y.U, dt, u, settings, p)
    return Track(belief, innovation, measured)


def mean_throttle(history: Sequence[tuple[int, float]], begin: int | None, end: int, timeout: int) -> float:
    """Return the mean over `begin` to `end` [ns] of a throttle [V] that is held between its instants [ns], ascending.

    NaN where it is not known: before its first value, or where the last one is older than `timeout` [ns] at `begin`.
    Without a beginning, or where none falls inside, it is the last value before; one of the instant `end` acts after.
    """
    if begin is None:
        history = [entry for entry in history if entry[0] < end]
        begin = end
    before = [entry for entry in history if entry[0] <= begin][-1:]
    inside = [entry for entry in history if begin < entry[0] < end]
    if not before or begin - before[0][0] > timeout:
        return nan
    if not inside:
        return before[0][1]
    pieces = [(begin, before[0][1]), *inside, (end, nan)]
    area = sum(u * (after - at) for (at, u), (after, _) in pairwise(pieces))
    return area / (end - begin)


def states(belief: Belief, settings: Any) -> tuple[float, float, float]:
    """Return n [rad/s], v and U [m/s] as far as the observer estimates them, else NaN."""
    if isinstance(settings, SpeedEkfSettings):
        return belief.n, nan, nan
    return belief.n, belief.v, belief.U


def covariance_matrix(belief: Belief) -> NDArray[np.float64]:
    """Return the covariance of n, v, U, (3, 3), NaN where the observer computes none."""
    P = covariance_of(belief)
    matrix = np.array([[P.nn, P.nv, P.nU], [P.nv, P.vv, P.vU], [P.nU, P.vU, P.UU]])
    none = [i for i, variance in enumerate((P.nn, P.vv, P.UU)) if isinf(variance)]
    if none:
        matrix[none, :] = nan
        matrix[:, none] = nan
    return matrix
