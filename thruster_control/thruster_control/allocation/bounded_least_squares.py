r"""Least squares with bounds, exactly, for a handful of unknowns and without any memory of its own.

    min |A x - b|^2    over    lower <= x <= upper

by an active set (Stark and Parker, Bounded-variable least squares, 1995): unknowns at a bound are held there, the free
ones solve their least squares by Householder reflections; one that is held against its slope is let go, and of those
that would pass a bound on the way to the new solution the first is held. With independent columns each change makes
the sum smaller, so that it ends, at the one solution there is. Rows of large weight belong first (the reflections then
keep small rows exact).
"""

import math

from thruster_model.compilation import compiled, equation

__all__ = ["bounded_least_squares", "compiled_bounded_least_squares"]

_FREE, _LOW, _HIGH, _FIXED = 0.0, -1.0, 1.0, 2.0
_TOLERANCE = 1e-11


@equation
def _solve_free(A, b, x, held, R, y):  # type: ignore[no-untyped-def]
    """Fill y (n,) with the solution for the free unknowns, the others as in x; R (m, n + 1) is overwritten."""
    m, n = A.shape
    count = 0
    for i in range(m):
        R[i, n] = b[i]
    for j in range(n):
        y[j] = x[j]
        if held[j] == _FREE:
            for i in range(m):
                R[i, count] = A[i, j]
            count += 1
        else:
            for i in range(m):
                R[i, n] -= A[i, j] * x[j]
    for k in range(count):
        length = 0.0
        for i in range(k, m):
            length += R[i, k] * R[i, k]
        length = math.sqrt(length)
        if length == 0.0:
            continue
        alpha = -length if R[k, k] > 0.0 else length
        head = R[k, k] - alpha
        scale = -1.0 / (alpha * head)  # 2 / |v|^2 with v = (head, R[k+1:, k])
        for j in range(k + 1, n + 1):
            if j >= count and j != n:
                continue
            total = head * R[k, j]
            for i in range(k + 1, m):
                total += R[i, k] * R[i, j]
            total *= scale
            R[k, j] -= total * head
            for i in range(k + 1, m):
                R[i, j] -= total * R[i, k]
        R[k, k] = alpha
    for k in range(count - 1, -1, -1):
        total = R[k, n]
        for j in range(k + 1, count):
            total -= R[k, j] * R[j, n]
        R[k, n] = total / R[k, k] if R[k, k] != 0.0 else 0.0
    at = 0
    for j in range(n):
        if held[j] == _FREE:
            y[j] = R[at, n]
            at += 1


@equation
def _against_slope(A, b, x, held, skipped):  # type: ignore[no-untyped-def]
    """Return the held unknown whose release makes the sum smaller fastest, -1 for none."""
    m, n = A.shape
    best, worst = -1, 0.0
    for j in range(n):
        if held[j] == _FREE or held[j] == _FIXED or j == skipped:
            continue
        slope, size = 0.0, 0.0
        for i in range(m):
            residual, reach = -b[i], abs(b[i])
            for k in range(n):
                residual += A[i, k] * x[k]
                reach += abs(A[i, k] * x[k])
            slope += A[i, j] * residual
            size += abs(A[i, j]) * reach
        gain = -slope if held[j] == _LOW else slope
        if gain > _TOLERANCE * size and gain > worst:
            best, worst = j, gain
    return best


@equation
def _first_bound(x, y, held, lower, upper):  # type: ignore[no-untyped-def]
    """Return (unknown, share): the first to reach a bound on the way from x to y; -1 for none."""
    first, share = -1, 1.0
    for j in range(x.shape[0]):
        if held[j] != _FREE:
            continue
        if y[j] < lower[j]:
            reached = (lower[j] - x[j]) / (y[j] - x[j])
        elif y[j] > upper[j]:
            reached = (upper[j] - x[j]) / (y[j] - x[j])
        else:
            continue
        if first < 0 or reached < share:
            first, share = j, min(max(reached, 0.0), 1.0)
    return first, share


@equation
def bounded_least_squares(A, b, lower, upper, x, held, R, y):  # type: ignore[no-untyped-def]
    """Fill x (n,) with the solution; return whether it was reached (else x is within its bounds, as good as found).

    Args:
        A, b: (m, n), (m,) with m >= n and independent columns.
        lower, upper: (n,), lower <= upper; equal ones fix an unknown.
        x: (n,), filled.
        held: (n,), filled: -1.0 at the lower bound, 1.0 at the upper one, 0.0 free, 2.0 fixed.
        R, y: (m, n + 1), (n,), overwritten.
    """
    n = x.shape[0]
    for j in range(n):
        held[j] = _FIXED if lower[j] == upper[j] else _FREE
        x[j] = min(max(0.0, lower[j]), upper[j])
    freed = -1
    for _ in range(20 * n):
        stuck = -1
        for _ in range(n + 1):
            _solve_free(A, b, x, held, R, y)
            first, share = _first_bound(x, y, held, lower, upper)
            if first < 0:
                break
            if first == freed and share == 0.0:
                stuck = first  # by rounding: what was let go is held again where it was
            for j in range(n):
                if held[j] == _FREE:
                    x[j] = min(max(x[j] + share * (y[j] - x[j]), lower[j]), upper[j])
            held[first] = _LOW if y[first] < lower[first] else _HIGH
            x[first] = lower[first] if y[first] < lower[first] else upper[first]
        for j in range(n):
            if held[j] == _FREE:
                x[j] = min(max(y[j], lower[j]), upper[j])
        freed = _against_slope(A, b, x, held, stuck)
        if freed < 0:
            return True
        held[freed] = _FREE
    return False


@compiled
def compiled_bounded_least_squares(A, b, lower, upper, x, held, R, y):  # type: ignore[no-untyped-def]
    """Fill x with the solution of `bounded_least_squares`, compiled; the same arguments."""
    return bounded_least_squares(A, b, lower, upper, x, held, R, y)
