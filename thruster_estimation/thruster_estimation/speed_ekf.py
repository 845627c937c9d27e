r"""Extended Kalman filter of the rotor speed n, one state (thesis 4.3, with the simplified model in 5.1).

State n [rad/s]; inputs u, the acting throttle [V], and v, the axial flow [m/s], which is 0 in the simplified model.

(3.8)         dn/dt = f(n) = -k_n n - k_Q Q(n, v) + gamma(u) + w,   E[w(t) w(s)] = q delta(t - s),  q [rad^2/s^3]
signed        z = n + e,       H = 1,        E[e^2] = r [rad^2/s^2]
unsigned      z = |n| + e,     H = sgn n̂

prediction    a = df/dn;   n̂ += f(n̂) (e^{ah} - 1) / a,   P = e^{2ah} P + q (e^{2ah} - 1) / (2a),   in sub-steps h

The correction, the gate and the unsigned tachometer: `correction`. A confident belief with the wrong sign is not found.
v and U are left what they are and carry no covariance: infinite, status NO_COVARIANCE.
"""

from math import expm1, inf, isfinite, nan

from thruster_estimation.belief import Status
from thruster_estimation.bench_form import euler_speed
from thruster_estimation.correction import innovation_of, speed_measured, widening
from thruster_estimation.drift import rotor_rate, rotor_slope
from thruster_estimation.matrices import Covariance
from thruster_estimation.propagation import drive_of, predicted_speed_variance, steps_of
from thruster_estimation.settings import BENCH
from thruster_estimation.stepping import concluded, period_of, with_unknown_drive
from thruster_model.compilation import equation

__all__ = ["corrected_speed", "predicted_speed", "speed_ekf_step"]

_AMBIGUOUS, _REOPENED, _CEILING = int(Status.AMBIGUOUS), int(Status.REOPENED), int(Status.CEILING)
_NO_COVARIANCE = int(Status.NO_COVARIANCE)


@equation
def speed_ekf_step(belief, y_n, y_U, dt, u, settings, p):  # type: ignore[no-untyped-def]
    """Return (Belief, Innovation) of the filter of n; y_U is not used. See `observers.observer_step`."""
    dt, flags = period_of(dt, u)
    n, v, P, drive = belief.n, belief.v, belief.P_nn, drive_of(belief.n, belief.v, u, p)
    if settings.form == BENCH:
        y, _, _ = speed_measured(n, P, y_n, settings)
        innovation = innovation_of(y, nan, P + settings.r_n, nan, nan, isfinite(y), False)
        if dt > 0.0:
            n, P = euler_speed(n, v, P, y_n if isfinite(y) else nan, dt, drive, settings, p)
            P = with_unknown_drive(P, u, dt, settings)
    else:
        n, P = predicted_speed(n, v, P, dt, drive, settings, p)
        n, P, innovation, flags = corrected_speed(
            n, with_unknown_drive(P, u, dt, settings), y_n, nan, False, belief.shut_n, flags, settings
        )
    whole = Covariance(P, 0.0, 0.0, inf, 0.0, inf)
    widest = Covariance(settings.largest_n**2, 0.0, 0.0, inf, 0.0, inf)
    return concluded(belief, n, v, belief.U, whole, innovation, flags | _NO_COVARIANCE, dt, widest, inf, settings)


@equation
def predicted_speed(n, v, P, dt, drive, settings, p):  # type: ignore[no-untyped-def]
    """Return (n, P) after `dt` [s] under a drive [rad/s^2] and an axial flow [m/s], both held."""
    count = steps_of(n, v, 0.0, dt, settings.largest_step, p)
    h = dt / count
    for _ in range(count):
        a = rotor_slope(n, v, p) * h
        after = n + h * (expm1(a) / a if a != 0.0 else 1.0) * rotor_rate(n, v, drive, p)
        P = predicted_speed_variance(P, n, after, v, h, settings.q_n, p)
        n = after
    return n, P


@equation
def corrected_speed(n, P, z, y_U, used_U, shut, flags, settings):  # type: ignore[no-untyped-def]
    """Return (n, P, Innovation, flags) after a tachometer's reading [rad/s]; y_U, used_U: of a flow, for the record."""
    largest = settings.largest_n * settings.largest_n
    at_ceiling = largest < P
    P = min(P, largest)
    y, r, ambiguous = speed_measured(n, P, z, settings)
    used, more = widening(y, P + r, settings.gate, shut, settings.patience)
    S = P + r if isfinite(y) else nan
    innovation = innovation_of(y, y_U, S, nan, nan, used, used_U)
    if used:
        P += more
        K = P / (P + r)
        n, P = n + K * y, (1.0 - K) ** 2 * P + K**2 * r
        flags |= (_AMBIGUOUS if ambiguous else 0) | (_REOPENED if more > 0.0 else 0)
    return n, P, innovation, flags | (_CEILING if at_ceiling else 0)
