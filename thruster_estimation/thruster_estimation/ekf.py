r"""Extended Kalman filter of n, v, U, and KFNLO, which adds the nonlinear observer's injection to it (thesis 4.3).

x = (n, v, U) by (4.3) to (4.5), z = (|n| or n, U). Predict over the period under the throttle that acted, then correct
with the measurements of its end, first n, then U. KFNLO in the thesis' sense: (4.16), (4.17) with the Kalman gains in
the place of k_11, k_21. Over a period dt the injection |n| k_12 ỹ, |n| k_22 ỹ alone makes of ỹ = y - Û

L_U = 1 - e^{-|n| k_22 dt},   L_v = (k_12 / k_22) L_U;         with the filter's gain K in all K + L (1 - K_U)

P is corrected with that whole gain (Joseph's form holds for any), so it knows what the injection costs.
"""

from math import exp, isfinite, nan

from thruster_estimation.belief import Status
from thruster_estimation.bench_form import euler_filter
from thruster_estimation.correction import bounded, corrected, innovation_of, speed_measured, widening
from thruster_estimation.gain_conditions import saturated_gains
from thruster_estimation.matrices import Covariance
from thruster_estimation.propagation import drive_of, predicted
from thruster_estimation.settings import BENCH
from thruster_estimation.stepping import concluded, period_of, refused_before, with_unknown_drive
from thruster_model.compilation import equation

__all__ = ["ekf_step", "injection", "kfnlo_step"]

_AMBIGUOUS, _REOPENED, _CEILING = int(Status.AMBIGUOUS), int(Status.REOPENED), int(Status.CEILING)


@equation
def ekf_step(belief, y_n, y_U, dt, u, settings, p):  # type: ignore[no-untyped-def]
    """Return (Belief, Innovation) of the extended Kalman filter; see `observers.observer_step`."""
    if settings.form == BENCH:
        return _euler_step(belief, y_n, y_U, dt, u, 0.0, 0.0, 0, settings, p)
    return _step(belief, y_n, y_U, dt, u, 0.0, 0.0, 0.0, 0.0, 0, 0, settings, p)


@equation
def kfnlo_step(belief, y_n, y_U, dt, u, settings, p):  # type: ignore[no-untyped-def]
    """Return (Belief, Innovation) of KFNLO; see `observers.observer_step`."""
    if settings.form == BENCH:
        g_v = settings.k_11 + abs(belief.n) * settings.k_12
        g_U = settings.k_21 + abs(belief.n) * settings.k_22
        return _euler_step(belief, y_n, y_U, dt, u, g_v, g_U, settings.printed, settings, p)
    return _step(
        belief, y_n, y_U, dt, u, settings.k_11, settings.k_12, settings.k_21, settings.k_22,
        settings.printed, settings.saturate, settings, p,
    )  # fmt: skip


@equation
def injection(g_v, g_U, dt):  # type: ignore[no-untyped-def]
    """Return (L_v, L_U), the shares of y - U that gains g [1/s], held over `dt` [s], add to v and U."""
    share = (1.0 - exp(-g_U * dt)) / g_U if abs(g_U) * dt > 1e-9 else dt
    return g_v * share, g_U * share


@equation
def _widest(settings):  # type: ignore[no-untyped-def]
    return Covariance(settings.largest_n**2, 0.0, 0.0, settings.largest_v**2, 0.0, settings.largest_U**2)


@equation
def _step(belief, z_n, z_U, dt, u, k_11, k_12, k_21, k_22, printed, saturate, settings, p):  # type: ignore[no-untyped-def]
    dt, flags = period_of(dt, u)
    n, v, U = belief.n, belief.v, belief.U
    limit = settings.gate * (belief.P_UU + settings.r_U)
    water = refused_before(belief, z_U, limit, settings.patience) if printed else nan
    P = Covariance(belief.P_nn, belief.P_nv, belief.P_nU, belief.P_vv, belief.P_vU, belief.P_UU)
    n, v, U, P = predicted(n, v, U, P, dt, drive_of(n, v, u, p), water, printed, settings, p)
    P = Covariance(with_unknown_drive(P.nn, u, dt, settings), P.nv, P.nU, P.vv, P.vU, P.UU)
    P, at_ceiling = bounded(P, settings.largest_n, settings.largest_v, settings.largest_U)

    y_n, r_n, ambiguous = speed_measured(n, P.nn, z_n, settings)
    y_U = z_U - U if isfinite(z_U) else nan
    S_nn = P.nn + r_n if isfinite(y_n) else nan
    S_UU = P.UU + settings.r_U if isfinite(y_U) else nan
    S_nU = P.nU if isfinite(y_n) and isfinite(y_U) else nan
    used_n, more_n = widening(y_n, S_nn, settings.gate, belief.shut_n, settings.patience)
    used_U, more_U = widening(y_U, S_UU, settings.gate, belief.shut_U, settings.patience)
    innovation = innovation_of(y_n, y_U, S_nn, S_nU, S_UU, used_n, used_U)
    P = Covariance(P.nn + more_n, P.nv, P.nU, P.vv, P.vU, P.UU + more_U)
    if used_n:
        S = P.nn + r_n
        n, v, U, P = corrected(n, v, U, P, y_n, r_n, True, P.nn / S, P.nv / S, P.nU / S)
        flags |= _AMBIGUOUS if ambiguous else 0
    if used_U:
        S = P.UU + settings.r_U
        K_n, K_v, K_U = P.nU / S, P.vU / S, P.UU / S
        if saturate and dt > 0.0:
            k_v, k_U = saturated_gains(K_v / dt, K_U / dt, p.k_v, p.k_U)
            K_v, K_U = k_v * dt, k_U * dt
        L_v, L_U = injection(k_11 + abs(n) * k_12, k_21 + abs(n) * k_22, dt)
        K_v, K_U = K_v + L_v * (1.0 - K_U), K_U + L_U * (1.0 - K_U)
        n, v, U, P = corrected(n, v, U, P, z_U - U, settings.r_U, False, K_n, K_v, K_U)
    flags |= (_CEILING if at_ceiling else 0) | (_REOPENED if more_n > 0.0 or more_U > 0.0 else 0)
    return concluded(belief, n, v, U, P, innovation, flags, dt, _widest(settings), settings.stale, settings)


@equation
def _euler_step(belief, z_n, z_U, dt, u, g_v, g_U, printed, settings, p):  # type: ignore[no-untyped-def]
    dt, flags = period_of(dt, u)
    n, v, U = belief.n, belief.v, belief.U
    P = Covariance(belief.P_nn, belief.P_nv, belief.P_nU, belief.P_vv, belief.P_vU, belief.P_UU)
    y_n, _, _ = speed_measured(n, P.nn, z_n, settings)
    y_U = z_U - U if isfinite(z_U) else nan
    S_nn = P.nn + settings.r_n if isfinite(y_n) else nan
    S_UU = P.UU + settings.r_U if isfinite(y_U) else nan
    S_nU = P.nU if isfinite(y_n) and isfinite(y_U) else nan
    innovation = innovation_of(y_n, y_U, S_nn, S_nU, S_UU, isfinite(y_n), isfinite(y_U))
    if dt > 0.0:
        z_n = z_n if isfinite(y_n) else nan
        n, v, U, P = euler_filter(
            n, v, U, P, z_n, z_U, dt, drive_of(n, v, u, p), g_v, g_U, printed, settings, p
        )  # fmt: skip
        P = Covariance(with_unknown_drive(P.nn, u, dt, settings), P.nv, P.nU, P.vv, P.vU, P.UU)
    return concluded(belief, n, v, U, P, innovation, flags, dt, _widest(settings), settings.stale, settings)
