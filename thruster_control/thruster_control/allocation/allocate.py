r"""One step of allocation: thrusts for a wrench, within limits, for kernels and for plain Python alike.

    T = K_t^-1 (tau - tau_stuck)                                              where that lies within the limits, else
    DIRECTION       max s over K_t T = s tau, 0 <= s <= 1                      the wrench keeps its direction
    LEAST_SQUARES   min |W (K_t T - tau)|^2, W = diag(1, 1, 1, w, w, w)        priority by weight
    PSEUDO_INVERSE  T as it is: the inner loops saturate

over lower <= T <= upper; of equal ones the shortest T. Both are the one problem

    min |W (K_t T - s tau)|^2 + c^2 (1 - s)^2 + epsilon^2 |T|^2

in (T, s), with s held at 1 for least squares, and for DIRECTION with a W so large that what it leaves of K_t T - s tau
can be taken off afterwards. Without null vectors DIRECTION is simply T shrunk. A limit beyond zero (a thruster that is
driven backwards by the stream) may leave no wrench of that direction: then least squares.

Then dead zones are avoided (`dead_zones`).
"""

from enum import IntEnum

import numpy as np

from thruster_control.allocation.bounded_least_squares import bounded_least_squares
from thruster_control.allocation.dead_zones import away_by_null_vectors, held_side
from thruster_control.allocation.settings import Method
from thruster_model.compilation import compiled, equation

__all__ = ["AllocationStatus", "allocate", "compiled_allocate"]

_DIRECTION, _LEAST_SQUARES = int(Method.DIRECTION), int(Method.LEAST_SQUARES)
_SHORT = 1e-6  # epsilon of least squares
_STIFF = 1e4  # W of DIRECTION
_SHORT_DIRECTION = 1e-4
_KEPT = 1e-6  # what may be left of the direction before it is taken off, of |tau|


class AllocationStatus(IntEnum):
    """What a step did."""

    EXACT = 0
    """The wrench is made, as far as any thrusts can."""
    REDUCED = 1
    """Limits: less of it is made."""
    BEYOND_LIMITS = 2
    """Limits are ignored (PSEUDO_INVERSE)."""
    NOT_FINITE = 3
    """A wrench or a limit is not a number: no thrust."""


_EXACT, _REDUCED, _BEYOND_LIMITS, _NOT_FINITE = map(int, AllocationStatus)


@equation
def _product(matrix, x, y, factor):  # type: ignore[no-untyped-def]
    """Fill y with factor * matrix @ x."""
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[1]):
            total += matrix[i, j] * x[j]
        y[i] = factor * total


@equation
def _within(T, lower, upper):  # type: ignore[no-untyped-def]
    within = True
    for i in range(T.shape[0]):
        within = within and lower[i] <= T[i] <= upper[i]
    return within


@equation
def _shrunk(T, lower, upper):  # type: ignore[no-untyped-def]
    """Return the largest s in [0, 1] for which s T is within the limits, -1.0 where none is."""
    low, high = 0.0, 1.0
    for i in range(T.shape[0]):
        if T[i] > 0.0:
            low, high = max(low, lower[i] / T[i]), min(high, upper[i] / T[i])
        elif T[i] < 0.0:
            low, high = max(low, upper[i] / T[i]), min(high, lower[i] / T[i])
        elif lower[i] > 0.0 or upper[i] < 0.0:
            return -1.0
    return high if low <= high else -1.0


@equation
def _solved(a, memory, lower, upper, direction, T):  # type: ignore[no-untyped-def]
    """Fill T with the bounded solution for memory.wrench; return s."""
    N = T.shape[0]
    A, b, wrench = memory.A, memory.b, memory.wrench
    size = 0.0
    for i in range(6):
        size = max(size, abs(wrench[i]))
    for row in range(6):
        i = (row + 3) % 6  # moments first: they weigh more
        weight = _STIFF if direction else a.weights[i]
        for j in range(N):
            A[row, j] = weight * a.K_t[i, j]
        A[row, N] = -weight * wrench[i]
        b[row] = 0.0
    A[6, :] = 0.0
    A[6, N] = size
    b[6] = size
    for j in range(N):
        A[7 + j, :] = 0.0
        A[7 + j, j] = _SHORT_DIRECTION if direction else _SHORT
        b[7 + j] = 0.0
        obeys = a.obeys[j] != 0.0
        memory.lower[j] = lower[j] if obeys else 0.0
        memory.upper[j] = upper[j] if obeys else 0.0
    memory.lower[N] = 0.0 if direction else 1.0
    memory.upper[N] = 1.0
    bounded_least_squares(A, b, memory.lower, memory.upper, memory.x, memory.held, memory.R, memory.y)
    for j in range(N):
        T[j] = memory.x[j]
    return memory.x[N]


@equation
def _same_direction(a, memory, lower, upper, T):  # type: ignore[no-untyped-def]
    """Fill T with the largest wrench of the direction of memory.wrench; return its share, -1.0 where there is none."""
    if a.null.shape[0] == 0:
        s = _shrunk(T, lower, upper)
        if s >= 0.0:
            for j in range(T.shape[0]):
                T[j] *= s
        return s
    s = _solved(a, memory, lower, upper, True, T)
    size, worst = 0.0, 0.0
    for i in range(6):
        left = -s * memory.wrench[i]
        for j in range(T.shape[0]):
            left += a.K_t[i, j] * T[j]
        memory.b[i] = left
        size, worst = max(size, abs(memory.wrench[i])), max(worst, abs(left))
    if worst > _KEPT * size:
        return -1.0
    for j in range(T.shape[0]):
        for i in range(6):
            T[j] -= a.inverse[j, i] * memory.b[i]
    rest = _shrunk(T, lower, upper)
    if rest < 0.0:
        return -1.0
    for j in range(T.shape[0]):
        T[j] *= rest
    return s * rest


@equation
def allocate(wrench, lower, upper, a, memory, T):  # type: ignore[no-untyped-def]
    """Fill T (N,) [N] with what to ask of each thruster; return (share, `AllocationStatus`).

    `share` is what the direction-keeping method leaves of the wrench; 1.0 with the others.

    Args:
        wrench: tau (6,) [N, N m].
        lower, upper: limits of each thruster (N,) [N], lower <= upper.
        a: `Allocation`.
        memory: `AllocationMemory` of this loop, changed in place; `achieved` is the wrench that T makes.
        T: (N,), filled.
    """
    N = T.shape[0]
    finite = True
    for i in range(6):
        memory.wrench[i] = wrench[i] - a.stuck[i]
        finite = finite and np.isfinite(wrench[i])
    for j in range(N):
        finite = finite and lower[j] <= upper[j]
    if not finite:
        T[:] = 0.0
        memory.side[:] = 0.0
        memory.along[:] = 0.0
        memory.achieved[:] = a.stuck
        return 0.0, _NOT_FINITE
    _product(a.inverse, memory.wrench, T, 1.0)
    _product(a.K_t, T, memory.wrench, 1.0)  # what of it can be made: all, but for lost directions
    share, status = 1.0, _EXACT
    for j in range(N):
        memory.lower[j] = lower[j] if a.obeys[j] != 0.0 else 0.0
        memory.upper[j] = upper[j] if a.obeys[j] != 0.0 else 0.0
        if a.obeys[j] == 0.0:
            T[j] = 0.0
    if not _within(T, memory.lower[:N], memory.upper[:N]):
        if a.method == _DIRECTION:
            status = _REDUCED
            share = _same_direction(a, memory, memory.lower[:N], memory.upper[:N], T)
        elif a.method != _LEAST_SQUARES:
            status = _BEYOND_LIMITS
        if a.method == _LEAST_SQUARES or share < 0.0:
            status, share = _REDUCED, 1.0
            _solved(a, memory, memory.lower[:N], memory.upper[:N], False, T)
    if a.smallest > 0.0:
        _avoid(a, memory, memory.lower[:N], memory.upper[:N], T)
    _product(a.K_t, T, memory.achieved, 1.0)
    for i in range(6):
        memory.achieved[i] += a.stuck[i]
    return share, status


@equation
def _avoid(a, memory, lower, upper, T):  # type: ignore[no-untyped-def]
    """Move T out of the dead zones, in place."""
    away_by_null_vectors(T, a.null, memory.along, a.smallest, a.hysteresis, lower, upper)
    for j in range(T.shape[0]):
        if a.obeys[j] != 0.0:
            moved, memory.side[j] = held_side(T[j], memory.side[j], a.smallest, a.hysteresis)
            T[j] = min(max(moved, min(lower[j], T[j])), max(upper[j], T[j]))


@compiled
def compiled_allocate(wrench, lower, upper, a, memory, T):  # type: ignore[no-untyped-def]
    """Fill T and return (share, status) of `allocate`, compiled; the same arguments."""
    return allocate(wrench, lower, upper, a, memory, T)
