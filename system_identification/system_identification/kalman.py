r"""Innovations of a disturbed system: a Kalman filter about a simulated run, as one linear map of the rows.

The system is linearised along the run; rates are pushed by disturbances w, readings carry a colour b and white noise e:

    dx_{k+1} = A_k dx_k + G_k w_k + h_k,     w, b: first-order Gauss-Markov,     y_i = c_i^T (dx_k, w_k) + b_s + e_i.

Shocks h of the states are white, of known variances: where a state rests that the slightest push moves on, nothing
foretells when it leaves.
A sample between two instants reads the pushes since the first one too; c may have no columns for them.

Measured less simulated rows are e.g. disturbed like that; the filter turns them into innovations that are white and of
standard deviation 1 where that is so (Kristensen, Madsen and Jorgensen 2004, Automatica 40, 225). Gains depend on the
model alone, so that residuals and the columns of a Jacobian pass through the same map.

The model is taken half way between what was simulated and where the real system most probably was: there the slope of
a square is that of the secant from one to the other, exactly.
"""

from typing import Any

import numba
import numpy as np

__all__ = ["driven_by", "gains_of", "innovations_of", "smoothed_of"]


def _kernel(function: Any) -> Any:
    """Compile; numba's own cache suffices, as no kernel calls another."""
    return numba.njit(cache=True, error_model="numpy")(function)


@_kernel
def gains_of(transition, push, unforeseen, keep, variance, places, readings, signals, noise, present, gains, deviation):  # type: ignore[no-untyped-def]
    """Fill the gains (M, D) and the deviations (M,) of a run's innovations; D = m states, q pushes, S colours.

    `unforeseen`: variances of what shocks the states over each step, (N, m); `keep`, `variance`: of pushes and
    colours, what is left of each after a step and its stationary variance, (q + S,); `signals`: which colour each
    sample carries, -1 for none, (M,); `noise`: variance of each sample's white noise (M,); rows that are not `present`
    are passed over.
    """
    count, m = transition.shape[0], transition.shape[1]
    q = push.shape[2]
    d = m + keep.size
    p = np.zeros((d, d))
    half = np.zeros((d, d))
    along = np.zeros(d)
    for j in range(keep.size):
        p[m + j, m + j] = variance[j]
    i = 0
    for k in range(count):
        while i < places.size and places[i] <= k:
            if present[i]:
                b = m + q + signals[i] if signals[i] >= 0 else -1
                for r in range(d):
                    value = p[r, b] if b >= 0 else 0.0
                    for c in range(readings.shape[1]):
                        value += p[r, c] * readings[i, c]
                    gains[i, r] = value
                s = noise[i] + (gains[i, b] if b >= 0 else 0.0)
                for c in range(readings.shape[1]):
                    s += readings[i, c] * gains[i, c]
                deviation[i] = np.sqrt(s)
                for r in range(d):
                    along[r] = gains[i, r]
                    gains[i, r] /= s
                for r in range(d):
                    gain = gains[i, r]
                    for c in range(d):
                        p[r, c] -= gain * along[c]
            i += 1
        a, g = transition[k], push[k]
        # half = F p, p = half F^T
        for c in range(d):
            for r in range(m):
                value = 0.0
                for j in range(m):
                    value += a[r, j] * p[j, c]
                for j in range(q):
                    value += g[r, j] * p[m + j, c]
                half[r, c] = value
            for j in range(keep.size):
                half[m + j, c] = keep[j] * p[m + j, c]
        for r in range(d):
            for c in range(m):
                value = 0.0
                for j in range(m):
                    value += half[r, j] * a[c, j]
                for j in range(q):
                    value += half[r, m + j] * g[c, j]
                p[r, c] = value
            for j in range(keep.size):
                p[r, m + j] = half[r, m + j] * keep[j]
        for r in range(m):
            p[r, r] += unforeseen[k, r]
        for j in range(keep.size):
            p[m + j, m + j] += (1.0 - keep[j] * keep[j]) * variance[j]


@_kernel
def innovations_of(  # type: ignore[no-untyped-def]
    transition, push, keep, places, readings, signals, present, gains, deviation, at, rows, most, out
):
    """Fill `out` (C, R) at a run's rows `at` (M,) with the innovations of columns `rows` (C, R) over their deviations.

    Rows that are not present, and columns that do nothing in the run, are left as they are; NaN counts as 0. What
    stands out by more than `most` deviations counts as that much; infinite: the map is linear.
    """
    count, m = transition.shape[0], transition.shape[1]
    q = push.shape[2]
    d = m + keep.size
    x, moved = np.zeros(d), np.zeros(m)
    for column in range(rows.shape[0]):
        silent = True
        for i in at:
            e = rows[column, i]
            if e != 0.0 and e == e:
                silent = False
                break
        if silent:
            continue
        x[:] = 0.0
        i = 0
        for k in range(count):
            while i < places.size and places[i] <= k:
                if present[i]:
                    e = rows[column, at[i]]
                    if e != e:
                        e = 0.0
                    if signals[i] >= 0:
                        e -= x[m + q + signals[i]]
                    for c in range(readings.shape[1]):
                        e -= readings[i, c] * x[c]
                    e = min(max(e, -most * deviation[i]), most * deviation[i])
                    out[column, at[i]] = e / deviation[i]
                    for r in range(d):
                        x[r] += gains[i, r] * e
                i += 1
            a, g = transition[k], push[k]
            for r in range(m):
                value = 0.0
                for j in range(m):
                    value += a[r, j] * x[j]
                for j in range(q):
                    value += g[r, j] * x[m + j]
                moved[r] = value
            for r in range(m):
                x[r] = moved[r]
            for j in range(keep.size):
                x[m + j] *= keep[j]


@_kernel
def smoothed_of(  # type: ignore[no-untyped-def]
    transition,
    push,
    unforeseen,
    keep,
    variance,
    places,
    readings,
    signals,
    present,
    gains,
    deviation,
    innovations,
    states,
):
    """Fill `states` (N, m) with the most probable ones of a run, by innovations (M,) over their deviations.

    Backwards to the shocks that pushed it, and forwards with these (de Jong 1988, Biometrika 75, 594; Durbin and
    Koopman 2012, section 4.5). Arguments as those of `gains_of`.
    """
    count, m = transition.shape[0], transition.shape[1]
    q = push.shape[2]
    d = m + keep.size
    r, earlier = np.zeros(d), np.zeros(m)
    shocks, own = np.zeros((count, q)), np.zeros((count, m))
    i = places.size - 1
    while i >= 0 and places[i] >= count:
        i -= 1
    for k in range(count - 1, -1, -1):
        a, g = transition[k], push[k]
        for j in range(m):
            own[k, j] = unforeseen[k, j] * r[j]
        for c in range(q):
            value = keep[c] * r[m + c]
            for j in range(m):
                value += g[j, c] * r[j]
            r[m + c] = value
        for c in range(q, keep.size):
            r[m + c] *= keep[c]
        for c in range(m):
            value = 0.0
            for j in range(m):
                value += a[j, c] * r[j]
            earlier[c] = value
        for c in range(m):
            r[c] = earlier[c]
        while i >= 0 and places[i] == k:
            if present[i]:
                pull = innovations[i] / deviation[i]
                for c in range(d):
                    pull -= gains[i, c] * r[c]
                for c in range(readings.shape[1]):
                    r[c] += readings[i, c] * pull
                if signals[i] >= 0:
                    r[m + q + signals[i]] += pull
            i -= 1
        for c in range(q):
            fresh = 1.0 - keep[c] * keep[c] if k > 0 else 1.0
            shocks[k, c] = fresh * variance[c] * r[m + c]
    w, x = np.zeros(q), np.zeros(m)
    for k in range(count):
        for c in range(q):
            w[c] = shocks[k, c] + (keep[c] * w[c] if k > 0 else 0.0)
        states[k] = x
        for c in range(m):
            value = own[k, c]
            for j in range(m):
                value += transition[k, c, j] * x[j]
            for j in range(q):
                value += push[k, c, j] * w[j]
            earlier[c] = value
        for c in range(m):
            x[c] = earlier[c]


@_kernel
def driven_by(transition, push, disturbance, out):  # type: ignore[no-untyped-def]
    """Fill `out` (N, q, m) with the states under each disturbance (q, N) by itself, at rest at the beginning."""
    count, m = transition.shape[0], transition.shape[1]
    x, moved = np.zeros(m), np.zeros(m)
    for j in range(push.shape[2]):
        x[:] = 0.0
        for k in range(count):
            for r in range(m):
                out[k, j, r] = x[r]
                value = push[k, r, j] * disturbance[j, k]
                for c in range(m):
                    value += transition[k, r, c] * x[c]
                moved[r] = value
            x[:] = moved
