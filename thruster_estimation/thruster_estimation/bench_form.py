r"""The observers as the bench ran them: explicit Euler of the continuous filter (Kalman and Bucy), period after period.

x̂[k+1] = x̂[k] + dt (f(x̂[k], u[k]) + K (y[k] - h(x̂[k]))),     h = (|n|, U),   K = P[k] H^T R^-1,   H = dh/dx̂[k]
P[k+1] = P[k] + dt (F P + P F^T + Q - P H^T R^-1 H P)

The measurement is that of the beginning of the period: x̂[k] is a prediction that y[k] has not entered yet.
H = sgn(n̂), 0 at n̂ = 0, in the filter of three states; in that of n alone, which NLO uses too, H^2 = 1.
NLO: (4.17) with n̂ of the filter of n alone, and (4.4) in the place of (4.16), so that the inflow is U and not
sgn(n) y. KFNLO: the filter's gain and, added to it, the NLO's whole injection (k_11 + |n̂| k_12) ỹ,
(k_21 + |n̂| k_22) ỹ; its P does not know of them. This reproduces the estimates that the bench recorded.
"""

from math import isfinite

import numpy as np

from thruster_estimation.drift import jacobian, rates, rotor_rate, rotor_slope
from thruster_estimation.matrices import Covariance
from thruster_model.compilation import equation

__all__ = ["euler_covariance", "euler_filter", "euler_observer", "euler_speed"]


@equation
def euler_speed(n, v, P, z, dt, drive, settings, p):  # type: ignore[no-untyped-def]
    """Return (n, P_nn) after a period; z: measured speed [rad/s], NaN: none."""
    seen = 1.0 if isfinite(z) else 0.0
    R = settings.r_n * dt
    sign = np.sign(n) if settings.unsigned else 1.0
    y = z - (abs(n) if settings.unsigned else n) if isfinite(z) else 0.0
    rate = rotor_rate(n, v, drive, p) + P / R * sign * y
    return n + dt * rate, P + dt * (2.0 * rotor_slope(n, v, p) * P + settings.q_n - seen * P * P / R)


@equation
def euler_observer(n, v, U, y, dt, settings, p):  # type: ignore[no-untyped-def]
    """Return (v, U) of the NLO after a period; y: measured ambient flow [m/s], NaN: none."""
    _, v_rate, U_rate = rates(n, v, U, 0.0, y, settings.printed, p)
    error = y - U if isfinite(y) else 0.0
    v_rate += settings.k_11 * error + abs(n) * settings.k_12 * error
    U_rate += settings.k_21 * error + abs(n) * settings.k_22 * error
    return v + dt * v_rate, U + dt * U_rate


@equation
def euler_covariance(P, F, h, seen_n, seen_U, dt, settings):  # type: ignore[no-untyped-def]
    """Return P after a period; h = dh/dn, seen: 1.0 where there was a measurement, else 0.0."""
    # the weight of the columns n and U: H^T R^-1 H
    a, b = seen_n * h * h / (settings.r_n * dt), seen_U / (settings.r_U * dt)
    FP_nn = F.nn * P.nn + F.nv * P.nv + F.nU * P.nU
    FP_nv = F.nn * P.nv + F.nv * P.vv + F.nU * P.vU
    FP_nU = F.nn * P.nU + F.nv * P.vU + F.nU * P.UU
    FP_vn = F.vn * P.nn + F.vv * P.nv + F.vU * P.nU
    FP_vv = F.vn * P.nv + F.vv * P.vv + F.vU * P.vU
    FP_vU = F.vn * P.nU + F.vv * P.vU + F.vU * P.UU
    FP_Un = F.Un * P.nn + F.Uv * P.nv + F.UU * P.nU
    FP_Uv = F.Un * P.nv + F.Uv * P.vv + F.UU * P.vU
    FP_UU = F.Un * P.nU + F.Uv * P.vU + F.UU * P.UU
    return Covariance(
        P.nn + dt * (2.0 * FP_nn + settings.q_n - a * P.nn * P.nn - b * P.nU * P.nU),
        P.nv + dt * (FP_nv + FP_vn - a * P.nn * P.nv - b * P.nU * P.vU),
        P.nU + dt * (FP_nU + FP_Un - a * P.nn * P.nU - b * P.nU * P.UU),
        P.vv + dt * (2.0 * FP_vv + settings.q_v - a * P.nv * P.nv - b * P.vU * P.vU),
        P.vU + dt * (FP_vU + FP_Uv - a * P.nv * P.nU - b * P.vU * P.UU),
        P.UU + dt * (2.0 * FP_UU + settings.q_U - a * P.nU * P.nU - b * P.UU * P.UU),
    )


@equation
def euler_filter(n, v, U, P, y_n, y_U, dt, drive, k_v, k_U, printed, settings, p):  # type: ignore[no-untyped-def]
    """Return (n, v, U, P) of the filter of three states after a period; k_v, k_U: gains added for y - U [1/s]."""
    seen_n, seen_U = 1.0 if isfinite(y_n) else 0.0, 1.0 if isfinite(y_U) else 0.0
    h = np.sign(n) if settings.unsigned else 1.0
    e_n = y_n - (abs(n) if settings.unsigned else n) if isfinite(y_n) else 0.0
    e_U = y_U - U if isfinite(y_U) else 0.0
    a, b = h * e_n / (settings.r_n * dt), e_U / (settings.r_U * dt)
    n_rate, v_rate, U_rate = rates(n, v, U, drive, y_U, printed, p)
    return (
        n + dt * (n_rate + P.nn * a + P.nU * b),
        v + dt * (v_rate + P.nv * a + P.vU * b + k_v * e_U),
        U + dt * (U_rate + P.nU * a + P.UU * b + k_U * e_U),
        euler_covariance(P, jacobian(n, v, U, p), h, seen_n, seen_U, dt, settings),
    )
