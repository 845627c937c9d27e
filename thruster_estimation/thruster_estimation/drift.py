r"""Rates of n, v, U as the observers assume them, and their Jacobian.

(4.3) to (4.5) with the model's functions; the NLO's inflow is that of (4.16) where `printed`:

(4.4)   dv/dt = -k_v v - k_Uv |v| (v - k_w U) + k_Tv T(n, v)
(4.16)  dv/dt = -k_v v - k_Uv v (|v| - k_w sgn(n) y) + k_Tv T(n, v)

The two differ where sgn v != sgn n: (4.16) is (4.4) with sgn(v) sgn(n) y in the place of U.
At the kinks of |n|, |v|, |U| the slope is 0; at the edges of a dead zone it is the one inside.
"""

from math import isfinite

import numpy as np

from thruster_estimation.matrices import Matrix
from thruster_model.compilation import equation
from thruster_model.equations.thruster import (
    ambient_acceleration,
    axial_acceleration,
    rotor_acceleration,
    thrust,
    torque,
)

__all__ = ["jacobian", "rates", "rotor_rate", "rotor_slope"]


@equation
def rotor_rate(n, v, drive, p):  # type: ignore[no-untyped-def]
    """Return dn/dt [rad/s^2] under the drive gamma(u) [rad/s^2]."""
    return rotor_acceleration(n, torque(n, v, p), drive, p)


@equation
def rates(n, v, U, drive, y, printed, p):  # type: ignore[no-untyped-def]
    """Return (dn/dt, dv/dt, dU/dt) [rad/s^2, m/s^2, m/s^2]; `y`: ambient flow that (4.16) takes in [m/s], NaN: U."""
    force = thrust(n, v, p)
    water = y if isfinite(y) else U
    inflow = np.sign(v) * np.sign(n) * water if printed else U
    return rotor_rate(n, v, drive, p), axial_acceleration(v, inflow, force, p), ambient_acceleration(U, force, p)


@equation
def _load_slopes(n, v, c_1, delta_1, c_2, delta_2, c_nv, c_v):  # type: ignore[no-untyped-def]
    """Return the derivatives of a load (4.12) to (4.15) by n and by v."""
    square = n * abs(n)
    slope = c_1 if square < delta_1 else (c_2 if square > delta_2 else 0.0)
    return 2.0 * abs(n) * slope - c_nv * np.sign(n) * v, -c_nv * abs(n) - 2.0 * c_v * abs(v)


@equation
def rotor_slope(n, v, p):  # type: ignore[no-untyped-def]
    """Return d(dn/dt)/dn [1/s]."""
    by_n, _ = _load_slopes(n, v, p.c_Q1, p.delta_Q1, p.c_Q2, p.delta_Q2, p.c_nv_Q, p.c_v_Q)
    return -p.k_n - 2.0 * p.k_2 * abs(n) - p.k_Q * by_n


@equation
def jacobian(n, v, U, p):  # type: ignore[no-untyped-def]
    """Return the Jacobian F of (4.3) to (4.5) over n, v, U."""
    _, torque_v = _load_slopes(n, v, p.c_Q1, p.delta_Q1, p.c_Q2, p.delta_Q2, p.c_nv_Q, p.c_v_Q)
    thrust_n, thrust_v = _load_slopes(n, v, p.c_T1, p.delta_T1, p.c_T2, p.delta_T2, p.c_nv_T, p.c_v_T)
    return Matrix(
        rotor_slope(n, v, p),
        -p.k_Q * torque_v,
        0.0,
        p.k_Tv * thrust_n,
        -p.k_v - p.k_Uv * (2.0 * abs(v) - np.sign(v) * p.k_w * U) + p.k_Tv * thrust_v,
        p.k_Uv * abs(v) * p.k_w,
        p.k_TU * thrust_n,
        p.k_TU * thrust_v,
        -p.k_U - 2.0 * p.k_UU * abs(U),
    )
