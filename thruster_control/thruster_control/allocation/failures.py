"""Failed thrusters: what the allocation does without them, and what to say about it.

    dead       no thrust: it is left out
    weak       gives `effectiveness` times what is asked for: it is asked for more
    stuck      keeps `stuck_thrust`: the others carry it, and it is asked for nothing
    no speed   its speed is not measured: it is used as before; its inner loop goes on without feedback

An effectiveness that is unknown (NaN) counts as `UNKNOWN_EFFECTIVENESS`, a stuck thrust that is unknown as the last
one asked for.
"""

from collections.abc import Mapping, Sequence
from enum import IntEnum
from math import inf, isfinite, isnan, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from thruster_control.allocation.configuration import AXES, inverse, lost_in_words, null_vectors, rank
from thruster_control.allocation.settings import Allocation, AllocationSettings

__all__ = [
    "UNKNOWN_EFFECTIVENESS", "Failure", "FailureKind", "allocation", "failures_in_words", "known", "problem",
]  # fmt: skip

UNKNOWN_EFFECTIVENESS = 0.5
_GIVEN_UP = 1e-3  # weight in least squares of an axis that is given up


class FailureKind(IntEnum):
    """As in thruster_msgs/ThrusterFailure."""

    NONE = 0
    DEAD = 1
    WEAK = 2
    STUCK = 3
    NO_SPEED = 4


class Failure(NamedTuple):
    """How one thruster has failed: effectiveness [1] of a weak one, thrust [N] of a stuck one; NaN: unknown."""

    kind: FailureKind
    effectiveness: float = nan
    stuck_thrust: float = nan


def problem(thruster: int, kind: int, effectiveness: float, stuck_thrust: float, thrusters: int) -> str:
    """Return what is wrong with a report as a sentence, "" where nothing is."""
    if not 0 <= thruster < thrusters:
        return f"thruster: expected an index from 0 to {thrusters - 1}; found {thruster}"
    if kind not in list(FailureKind):
        return f"kind: expected one of {', '.join(f'{each} ({each.name})' for each in FailureKind)}; found {kind}"
    if kind == FailureKind.WEAK and not (isnan(effectiveness) or 0.0 < effectiveness < inf):
        return f"effectiveness: expected a finite number above 0, or NaN for unknown; found {effectiveness}"
    if kind == FailureKind.STUCK and not (isnan(stuck_thrust) or isfinite(stuck_thrust)):
        return f"stuck_thrust: expected a finite number of newtons, or NaN for unknown; found {stuck_thrust}"
    return ""


def known(failure: Failure, last_thrust: float) -> Failure:
    """Return the failure with what is unknown of it replaced; `last_thrust` [N] was asked for last."""
    if not _unsized(failure):
        return failure
    if failure.kind == FailureKind.WEAK:
        return failure._replace(effectiveness=UNKNOWN_EFFECTIVENESS)
    return failure._replace(stuck_thrust=last_thrust)


def _unsized(failure: Failure) -> bool:
    return (failure.kind == FailureKind.WEAK and isnan(failure.effectiveness)) or (
        failure.kind == FailureKind.STUCK and isnan(failure.stuck_thrust)
    )


def allocation(
    configuration: ArrayLike, settings: AllocationSettings, failures: Mapping[int, Failure] | None = None
) -> Allocation:
    """Return what a kernel needs to allocate with these failures, whose sizes are known.

    Args:
        configuration: K_t (6, N) of the vehicle.
        settings: what is chosen.
        failures: by index of the thruster.

    Raises:
        ValueError: K_t is no matrix of that shape, or a failure's size is unknown or its thruster not there.
    """
    K_t = np.array(configuration, dtype=np.float64)
    gives = np.array(K_t)
    stuck, obeys = np.zeros(6), np.ones(K_t.shape[-1])
    for thruster, failure in (failures or {}).items():
        sentence = problem(thruster, failure.kind, failure.effectiveness, failure.stuck_thrust, K_t.shape[-1])
        if sentence or _unsized(failure):
            raise ValueError(sentence or f"thruster {thruster}: expected a failure of known size; found {failure}")
        if failure.kind in (FailureKind.DEAD, FailureKind.STUCK):
            gives[:, thruster], obeys[thruster] = 0.0, 0.0
        if failure.kind == FailureKind.STUCK:
            stuck += K_t[:, thruster] * failure.stuck_thrust
        if failure.kind == FailureKind.WEAK:
            gives[:, thruster] *= failure.effectiveness
    m = settings.moment_weight
    weights = np.array([1.0, 1.0, 1.0, m, m, m])
    weights[[AXES.index(axis) for axis in settings.given_up]] = _GIVEN_UP
    return Allocation(
        np.ascontiguousarray(gives),
        inverse(gives, settings.given_up),
        np.ascontiguousarray(null_vectors(gives)),
        stuck,
        obeys,
        weights,
        int(settings.method),
        float(settings.smallest_thrust),
        float(settings.hysteresis),
    )


def failures_in_words(
    configuration: ArrayLike, failures: Mapping[int, Failure] | None = None, given_up: Sequence[str] = ()
) -> str:
    """Return what has failed and which directions of the wrench are lost, "" where nothing is."""
    said = []
    gives = np.array(configuration, dtype=np.float64)
    for thruster, failure in sorted((failures or {}).items()):
        words = {
            FailureKind.DEAD: "is dead",
            FailureKind.WEAK: f"is weak ({failure.effectiveness:g} of what is asked for)",
            FailureKind.STUCK: f"is stuck at {failure.stuck_thrust:g} N",
            FailureKind.NO_SPEED: "runs without a measured speed",
        }
        if failure.kind in words:
            said.append(f"thruster {thruster} {words[failure.kind]}")
        if failure.kind in (FailureKind.DEAD, FailureKind.STUCK):
            gives[:, thruster] = 0.0
    if (found := rank(gives)) < 6:
        said.append(f"K_t has rank {found} of 6: no control of {lost_in_words(gives, given_up)}")
        if np.linalg.matrix_rank(gives[3:]) == 3 and not given_up:
            said[-1] += ", attitude is kept before translation"
    return "; ".join(said)
