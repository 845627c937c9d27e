"""What every observer's step shares: the period that counts, the ages of the measurements, the status, the restart."""

from math import isfinite, nan

from thruster_estimation.belief import Belief, Innovation, Status
from thruster_model.compilation import equation

__all__ = ["concluded", "period_of", "refused_before", "with_unknown_drive"]

_USED_N, _USED_U = int(Status.USED_N), int(Status.USED_U)
_GATED_N, _GATED_U = int(Status.GATED_N), int(Status.GATED_U)
_STALE_N, _STALE_U = int(Status.STALE_N), int(Status.STALE_U)
_NO_THROTTLE, _BAD_PERIOD = int(Status.NO_THROTTLE), int(Status.BAD_PERIOD)
_RESTARTED, _PREDICTED = int(Status.RESTARTED), int(Status.PREDICTED)


@equation
def period_of(dt, u):  # type: ignore[no-untyped-def]
    """Return (the period that is predicted over [s], flags for what is wrong with it or with the throttle)."""
    usable = isfinite(dt) and dt >= 0.0
    flags = (0 if usable else _BAD_PERIOD) | (0 if isfinite(u) else _NO_THROTTLE)
    return (dt if usable else 0.0), flags


@equation
def with_unknown_drive(P_nn, u, dt, settings):  # type: ignore[no-untyped-def]
    """Return the variance of n [rad^2/s^2] with what an unknown throttle may have done to it in `dt` [s]."""
    return P_nn if isfinite(u) else P_nn + (settings.unknown_drive * dt) ** 2


@equation
def refused_before(belief, y, limit, patience):  # type: ignore[no-untyped-def]
    """Return y [m/s], or NaN where it already lies too far [m^2/s^2] from the belief to enter the prediction."""
    error = y - belief.U
    return y if isfinite(error) and (error * error <= limit or belief.shut_U >= patience) else nan


@equation
def concluded(belief, n, v, U, P, innovation, flags, dt, restart, stale_U, settings):  # type: ignore[no-untyped-def]
    """Return (Belief, Innovation) with status and ages; a step that left the finite numbers starts again.

    restart: covariance of a new start; stale_U: time [s] without ambient flow after which the status says so.
    """
    sound = isfinite(n) and isfinite(v) and isfinite(U) and isfinite(P.nn + P.nv + P.nU + P.vU)
    sound = sound and P.vv == P.vv and P.UU == P.UU and P.nn >= 0.0 and P.vv >= 0.0 and P.UU >= 0.0
    if not sound:
        n, v, U = 0.0, 0.0, 0.0
        P = restart
        innovation = Innovation(nan, nan, nan, nan, nan, nan, nan, nan, 0, 0, 0, 0, 0)
        flags |= _RESTARTED
    unseen_n = 0.0 if innovation.used_n else belief.unseen_n + dt
    unseen_U = 0.0 if innovation.used_U else belief.unseen_U + dt
    shut_n = 0.0 if innovation.used_n else belief.shut_n + innovation.gated_n * dt
    shut_U = 0.0 if innovation.used_U else belief.shut_U + innovation.gated_U * dt
    flags |= innovation.used_n * _USED_N | innovation.used_U * _USED_U
    flags |= innovation.gated_n * _GATED_N | innovation.gated_U * _GATED_U
    flags |= 0 if innovation.used_n or innovation.used_U else _PREDICTED
    flags |= (_STALE_N if unseen_n > settings.stale else 0) | (_STALE_U if unseen_U > stale_U else 0)
    after = Belief(
        n, v, U, P.nn, P.nv, P.nU, P.vv, P.vU, P.UU, flags, unseen_n, unseen_U, shut_n, shut_U
    )  # fmt: skip
    return after, innovation
