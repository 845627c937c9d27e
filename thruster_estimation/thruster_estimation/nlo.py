r"""The nonlinear observer of Fossen and Blanke for v and U (thesis 4.3), beside the filter of n alone.

(4.16)  dv̂/dt = -k_v v̂ - k_Uv v̂ (|v̂| - k_w sgn(n) y) + k_Tv T(n, v̂) + k_11 ỹ + |n| k_12 ỹ,       ỹ = y - Û
(4.17)  dÛ/dt = -k_U Û - k_UU Û|Û| + k_TU T(n, v̂) + k_21 ỹ + |n| k_22 ỹ

n is estimated by the filter of `speed_ekf`, with v̂ in the torque. Over a period the drift is integrated by RK4, in
which y goes straight from Û at the beginning to the sample at the end; then the injection acts on ỹ at the end for as
long as the period was, n held. An exact estimate stays exact where (4.16) is the truth; with (4.4) as the truth it is
left at each reversal, where sgn v != sgn n. The observer has no covariance of v and U: it is infinite in the belief.
"""

from math import inf, isfinite, nan

from thruster_estimation.belief import Status
from thruster_estimation.bench_form import euler_observer, euler_speed
from thruster_estimation.correction import innovation_of, speed_measured
from thruster_estimation.ekf import injection
from thruster_estimation.matrices import Covariance
from thruster_estimation.propagation import drive_of, predicted_speed_variance, rk4, steps_of
from thruster_estimation.settings import BENCH
from thruster_estimation.speed_ekf import corrected_speed
from thruster_estimation.stepping import concluded, period_of, refused_before, with_unknown_drive
from thruster_model.compilation import equation

__all__ = ["nlo_step"]

_NO_COVARIANCE, _REOPENED = int(Status.NO_COVARIANCE), int(Status.REOPENED)


@equation
def nlo_step(belief, y_n, y_U, dt, u, settings, p):  # type: ignore[no-untyped-def]
    """Return (Belief, Innovation) of the nonlinear observer; see `observers.observer_step`."""
    dt, flags = period_of(dt, u)
    n, v, U, P, drive = belief.n, belief.v, belief.U, belief.P_nn, drive_of(belief.n, belief.v, u, p)
    if settings.form == BENCH:
        e_n, _, _ = speed_measured(n, P, y_n, settings)
        e_U = y_U - U if isfinite(y_U) else nan
        innovation = innovation_of(e_n, e_U, P + settings.r_n, nan, nan, isfinite(e_n), isfinite(e_U))
        if dt > 0.0:
            n, P = euler_speed(n, v, P, y_n if isfinite(e_n) else nan, dt, drive, settings, p)
            P = with_unknown_drive(P, u, dt, settings)
            v, U = euler_observer(belief.n, v, U, y_U, dt, settings, p)
    else:
        limit = settings.largest_innovation * settings.largest_innovation
        y = refused_before(belief, y_U, limit, settings.patience) if settings.printed else nan
        count = steps_of(n, v, U, dt, settings.largest_step, p)
        h = dt / count
        for k in range(count):
            y_0 = belief.U + (y - belief.U) * k / count
            y_1 = belief.U + (y - belief.U) * (k + 1) / count
            n_1, v_1, U_1 = rk4(n, v, U, drive, y_0, y_1, h, settings.printed, p)
            P = predicted_speed_variance(P, n, n_1, 0.5 * (v + v_1), h, settings.q_n, p)
            n, v, U = n_1, v_1, U_1
        e_U = y_U - U if isfinite(y_U) else nan
        within = isfinite(e_U) and e_U * e_U <= limit
        used_U = within or (isfinite(e_U) and belief.shut_U >= settings.patience)
        P = with_unknown_drive(P, u, dt, settings)
        n, P, innovation, flags = corrected_speed(n, P, y_n, e_U, used_U, belief.shut_n, flags, settings)
        if used_U:
            g_v, g_U = settings.k_11 + abs(n) * settings.k_12, settings.k_21 + abs(n) * settings.k_22
            L_v, L_U = injection(g_v, g_U, dt)
            v, U = v + L_v * e_U, U + L_U * e_U
            flags |= 0 if within else _REOPENED
    whole = Covariance(P, 0.0, 0.0, inf, 0.0, inf)
    widest = Covariance(settings.largest_n**2, 0.0, 0.0, inf, 0.0, inf)
    return concluded(belief, n, v, U, whole, innovation, flags | _NO_COVARIANCE, dt, widest, settings.stale, settings)
