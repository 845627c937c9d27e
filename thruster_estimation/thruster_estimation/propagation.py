r"""Prediction over one period: RK4 of the states, matrix exponential of the covariance, in sub-steps.

Phi = e^{F h} at the middle of the sub-step,  P <- Phi P Phi^T + Q_d,
Q_d = int_0^h e^{F s} Q e^{F^T s} ds by Simpson's rule: a sum of congruent matrices, so P stays symmetric and
positive semidefinite. Sub-steps are shortened where the dynamics are fast, as at large axial flow.
"""

from math import ceil, exp, expm1, isfinite

from thruster_estimation.drift import jacobian, rates, rotor_slope
from thruster_estimation.matrices import Covariance, congruent, exponential, product
from thruster_model.compilation import equation
from thruster_model.equations.thruster import input_map

__all__ = ["drive_of", "predicted", "predicted_speed_variance", "rk4", "steps_of"]

_MOST_STEPS = 1000
_NOISE_SHARES = (1.0 / 6.0, 4.0 / 6.0)


@equation
def drive_of(n, v, u, p):  # type: ignore[no-untyped-def]
    """Return the drive [rad/s^2] of the throttle [V]; where that is not known, the one that holds n."""
    if isfinite(u):
        return input_map(u, p)
    return -rates(n, v, 0.0, 0.0, 0.0, False, p)[0] / p.drive_gain


@equation
def steps_of(n, v, U, dt, largest_step, p):  # type: ignore[no-untyped-def]
    """Return the number of sub-steps: each at most `largest_step` [s] and at most one time constant of the sum."""
    F = jacobian(n, v, U, p)
    rate = abs(F.nn) + abs(F.vv) + abs(F.UU)
    wanted = dt * max(1.0 / largest_step, rate) - 1e-9
    return max(ceil(wanted), 1) if wanted < _MOST_STEPS else _MOST_STEPS


@equation
def rk4(n, v, U, drive, y, y_end, h, printed, p):  # type: ignore[no-untyped-def]
    """Return (n, v, U) after one RK4 step of h [s]; the ambient flow of (4.16) goes straight from `y` to `y_end`."""
    half, middle = 0.5 * h, 0.5 * (y + y_end)
    n1, v1, U1 = rates(n, v, U, drive, y, printed, p)
    n2, v2, U2 = rates(n + half * n1, v + half * v1, U + half * U1, drive, middle, printed, p)
    n3, v3, U3 = rates(n + half * n2, v + half * v2, U + half * U2, drive, middle, printed, p)
    n4, v4, U4 = rates(n + h * n3, v + h * v3, U + h * U3, drive, y_end, printed, p)
    sixth = h / 6.0
    return (
        n + sixth * (n1 + 2.0 * (n2 + n3) + n4),
        v + sixth * (v1 + 2.0 * (v2 + v3) + v4),
        U + sixth * (U1 + 2.0 * (U2 + U3) + U4),
    )


@equation
def predicted(n, v, U, P, dt, drive, y, printed, settings, p):  # type: ignore[no-untyped-def]
    """Return (n, v, U, P) after `dt` [s]; `y`: ambient flow measured at the end [m/s], where (4.16) takes it in."""
    count = steps_of(n, v, U, dt, settings.largest_step, p)
    h, start = dt / count, U
    for k in range(count):
        y_0, y_1 = start + (y - start) * k / count, start + (y - start) * (k + 1) / count
        n_next, v_next, U_next = rk4(n, v, U, drive, y_0, y_1, h, printed, p)
        P = _spread(P, jacobian(0.5 * (n + n_next), 0.5 * (v + v_next), 0.5 * (U + U_next), p), h, settings)
        n, v, U = n_next, v_next, U_next
    return n, v, U, P


@equation
def _spread(P, F, h, settings):  # type: ignore[no-untyped-def]
    half = exponential(F, 0.5 * h)
    whole = product(half, half)
    end, middle = _NOISE_SHARES
    Q = Covariance(settings.q_n * h, 0.0, 0.0, settings.q_v * h, 0.0, settings.q_U * h)
    a, b, c = congruent(whole, P), congruent(half, Q), congruent(whole, Q)
    return Covariance(
        a.nn + end * (Q.nn + c.nn) + middle * b.nn,
        a.nv + end * c.nv + middle * b.nv,
        a.nU + end * c.nU + middle * b.nU,
        a.vv + end * (Q.vv + c.vv) + middle * b.vv,
        a.vU + end * c.vU + middle * b.vU,
        a.UU + end * (Q.UU + c.UU) + middle * b.UU,
    )


@equation
def predicted_speed_variance(P, n, n_next, v, h, q, p):  # type: ignore[no-untyped-def]
    """Return the variance of n alone after h [s]: exact for the mean slope of the rotor's equation."""
    a = rotor_slope(0.5 * (n + n_next), v, p)
    twice = 2.0 * a * h
    spread = expm1(twice) / twice if twice != 0.0 else 1.0
    return exp(twice) * P + q * h * spread
