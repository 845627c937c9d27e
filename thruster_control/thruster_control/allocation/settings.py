"""How a wrench is allocated: what is chosen, and what a kernel gets of it."""

from dataclasses import dataclass
from enum import IntEnum
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_control.allocation.configuration import groups

__all__ = ["Allocation", "AllocationMemory", "AllocationSettings", "Method", "allocation_memory"]

Array = NDArray[np.float64]


class Method(IntEnum):
    """What is done with a wrench that the thrusters' limits do not allow."""

    PSEUDO_INVERSE = 0
    """Nothing: thrusts as in the thesis, and the inner loops saturate."""
    DIRECTION = 1
    """The wrench keeps its direction and loses size."""
    LEAST_SQUARES = 2
    """The weighted error of the wrench is made as small as it can be."""


@dataclass(frozen=True, kw_only=True)
class AllocationSettings:
    """What is chosen.

    Attributes:
        method: of `Method`.
        moment_weight: weight of a newton metre of error against a newton of it, in least squares [1/m].
        smallest_thrust: thrusters keep |T| at this or above where they can [N]; 0: dead zones are not avoided.
        hysteresis: how much better another way around a dead zone must be before it is taken [N].
        given_up: axes of `configuration.AXES` whose wrench counts last, for a vehicle that is steady there by itself.
    """

    method: Method = Method.LEAST_SQUARES
    moment_weight: float = 10.0
    smallest_thrust: float = 0.0
    hysteresis: float = 0.2
    given_up: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        wrong = []
        if self.method not in list(Method):
            wrong.append(f"method: expected one of {', '.join(each.name for each in Method)}; found {self.method!r}")
        if not 1e-3 <= self.moment_weight <= 1e3:
            wrong.append(f"moment_weight: expected a number from 0.001 to 1000 1/m; found {self.moment_weight}")
        for name in ("smallest_thrust", "hysteresis"):
            if not 0.0 <= getattr(self, name) < inf:
                wrong.append(f"{name}: expected a finite number of newtons, 0 or more; found {getattr(self, name)}")
        try:
            groups(self.given_up)
        except ValueError as error:
            wrong.append(str(error))
        if wrong:
            raise ValueError("; ".join(wrong))


class Allocation(NamedTuple):
    """What a kernel gets: of one state of the thrusters, failures included (`failures.allocation`).

    K_t (6, N): wrench for what is asked of each thruster, zeros for one that does not obey; inverse (N, 6);
    null (k, N): null vectors; stuck (6,): wrench of thrusters that do not obey [N, N m]; obeys (N,): 1.0 or 0.0;
    weights (6,); method: of `Method`; smallest, hysteresis [N].
    """

    K_t: Array
    inverse: Array
    null: Array
    stuck: Array
    obeys: Array
    weights: Array
    method: int
    smallest: float
    hysteresis: float


class AllocationMemory(NamedTuple):
    """What the step remembers and writes on, changed in place.

    side (N,): on which side of its dead zone a thruster turns; along (N,): share of each null vector [N];
    achieved (6,): the wrench of the last thrusts [N, N m]; the others are room to compute in.
    """

    side: Array
    along: Array
    achieved: Array
    wrench: Array
    A: Array
    b: Array
    x: Array
    y: Array
    held: Array
    lower: Array
    upper: Array
    R: Array


def allocation_memory(thrusters: int) -> AllocationMemory:
    """Return the memory before the first step, for so many thrusters; each loop needs its own."""
    n, rows = thrusters + 1, thrusters + 7
    shapes = ((thrusters,), (thrusters,), (6,), (6,), (rows, n), (rows,), (n,), (n,), (n,), (n,), (n,), (rows, n + 1))
    return AllocationMemory(*(np.zeros(shape) for shape in shapes))
