r"""What each law asks for: the wrench for a state and a set point.

(2.22)  tau = C(nu) nu + D(nu) nu + g + M a_d - M (K_P Dnu + k),   a_d = dnu_d/dt,  Dnu = nu - nu_d

so that with the exact wrench, (2.24), dDnu/dt = -K_P Dnu - k. Three forms of nu_2d, a_2d and k:

EulerLaw        k = k_I [0; J_2(eta)^T Deta], Deta = eta_2 - eta_2d wrapped, nu_2d = J_2(eta)^-1 deta_d/dt and
                a_2d = J_2^-1 (d2eta_d/dt2 - (dJ_2/dt) nu_2d) with the **measured** eta, so that dDeta/dt = J_2 Dnu_2.
                V = |Dnu|^2 / 2 + k_I |Deta|^2 / 2,   dV/dt = -Dnu^T K_P Dnu.
                J_2 has no bound towards 90 degrees of pitch: beyond `steepest` it is that at `steepest`.
QuaternionLaw   q_e = q_d* q, body axes as seen from the desired ones; w, epsilon: its parts; R_e its rotation matrix.
                nu_2d = R_e^T omega_d, a_2d = R_e^T domega_d/dt - Dnu_2 x nu_2d: the desired rates in body axes; omega_d
                = J_2(eta_d)^-1 deta_d/dt, which is regular at every eta_d. Then dw/dt = -epsilon^T Dnu_2 / 2.
                k = 2 k_I [0; epsilon].
                V = |Dnu|^2 / 2 + 4 k_I (1 - w),   dV/dt = -Dnu^T K_P Dnu.
                q_e and -q_e are the same attitude: taken is the one with w >= 0, the shorter way, at first, then the
                one that continues it, changed only where w < -hysteresis, at which V falls: neither the sign in which
                an attitude comes nor noise at half a turn makes it chatter. The only rest with w >= -hysteresis is
                epsilon = 0, w = 1: it is reached from every attitude.
                For small errors 2 epsilon = Deta and 4 (1 - w) = |Deta|^2 / 2: the same gains as the Euler form.
LinearLaw       the Euler form made linear at eta = 0, nu = 0:
                tau = level + slope eta_2 + D_L nu + M (a_d - K_P Dnu - k_I [0; Deta]), nu_2d = deta_d/dt.
PidLaw          tau_i = proportional_i e_i + integral_i z_i (+ derivative_i times -Dnu_2i), cut at +-largest_i,
                e = (-Dnu_1, -2 epsilon), dz_i/dt = e_i but where the cut or the thrusters' shortfall has its sign.

A position is not fed back, as in the thesis. Law and settings go together by class.
"""

from collections.abc import Callable
from typing import Any

from numba.extending import overload

from thruster_control.outer_loop.body_rates import body_acceleration, body_rates
from thruster_control.outer_loop.model import add_inertia, model_terms
from thruster_control.outer_loop.settings import EulerLaw, LinearLaw, PidLaw, QuaternionLaw
from thruster_model.compilation import equation
from thruster_model.equations.attitude import (
    conjugate,
    euler_from_quaternion,
    euler_rate_matrix,
    matrix_times,
    normalised,
    quaternion_from_euler,
    quaternion_product,
    rotated_back,
    wrapped,
)

__all__ = ["desired_rates", "law_wrench", "quaternion_error"]

Equation = Callable[..., Any]
_SHORT = 1e-6  # N or N m: a shortfall below this is rounding


@equation
def quaternion_error(q, sp):  # type: ignore[no-untyped-def]
    """Return q_e = q_d* q as (w, x, y, z)."""
    return normalised(quaternion_product(conjugate(quaternion_from_euler(sp.attitude)), q))


@equation
def desired_rates(q_e, nu_2, sp):  # type: ignore[no-untyped-def]
    """Return (nu_2d, a_2d) of the quaternion form, in body axes [rad/s, rad/s^2]."""
    rate = sp.attitude_rate
    omega = rotated_back(q_e, body_rates(sp.attitude, rate))
    a = rotated_back(q_e, body_acceleration(sp.attitude, rate, rate, sp.attitude_acceleration))
    x, y, z = nu_2[0] - omega[0], nu_2[1] - omega[1], nu_2[2] - omega[2]
    return omega, (
        a[0] - (y * omega[2] - z * omega[1]),
        a[1] - (z * omega[0] - x * omega[2]),
        a[2] - (x * omega[1] - y * omega[0]),
    )


@equation
def _chosen(q_e, memory, hysteresis):  # type: ignore[no-untyped-def]
    """Return q_e or -q_e: the one that continues the former choice, the other where its w is below -hysteresis."""
    former = memory.error
    along = q_e[0] * former[0] + q_e[1] * former[1] + q_e[2] * former[2] + q_e[3] * former[3]
    s = 1.0 if along > 0.0 or (along == 0.0 and q_e[0] >= 0.0) else -1.0
    if s * q_e[0] < -hysteresis:
        s = -s
    for i in range(4):
        former[i] = s * q_e[i]
    return former[0], former[1], former[2], former[3]


@equation
def _feedback(c, law, nu, sp, omega_d, a_d, k, memory, wrench):  # type: ignore[no-untyped-def]
    """Add M (a_d - K_P Dnu - [0; k]) to the wrench, with the rates' desired values in body axes."""
    error, wanted = memory.terms, memory.wanted
    for i in range(3):
        error[i] = nu[i] - sp.velocity[i]
        error[3 + i] = nu[3 + i] - omega_d[i]
        wanted[i] = sp.acceleration[i]
        wanted[3 + i] = a_d[i] - k[i]
    for i in range(6):
        for j in range(6):
            wanted[i] -= law.K_P[i, j] * error[j]
    add_inertia(c, wanted, wrench)


@equation
def _quaternion(q, nu, sp, dt, law, c, memory, wrench):  # type: ignore[no-untyped-def]
    q_e = _chosen(quaternion_error(q, sp), memory, law.hysteresis)
    omega_d, a_d = desired_rates(q_e, (nu[3], nu[4], nu[5]), sp)
    gain = 2.0 * law.k_I
    model_terms(c, q, nu, wrench)
    _feedback(c, law, nu, sp, omega_d, a_d, (gain * q_e[1], gain * q_e[2], gain * q_e[3]), memory, wrench)
    return True


@equation
def _euler(q, nu, sp, dt, law, c, memory, wrench):  # type: ignore[no-untyped-def]
    phi, theta, psi = euler_from_quaternion(q)
    bounded = min(max(theta, -law.steepest), law.steepest)
    angles = (phi, bounded, psi)
    d_1, d_2, d_3 = wrapped(phi - sp.attitude[0]), wrapped(theta - sp.attitude[1]), wrapped(psi - sp.attitude[2])
    J_2 = euler_rate_matrix(angles)
    omega_d = body_rates(angles, sp.attitude_rate)
    turning = matrix_times(J_2, (nu[3], nu[4], nu[5]))
    a_d = body_acceleration(angles, turning, sp.attitude_rate, sp.attitude_acceleration)
    k = (
        law.k_I * (J_2[0][0] * d_1 + J_2[1][0] * d_2 + J_2[2][0] * d_3),
        law.k_I * (J_2[0][1] * d_1 + J_2[1][1] * d_2 + J_2[2][1] * d_3),
        law.k_I * (J_2[0][2] * d_1 + J_2[1][2] * d_2 + J_2[2][2] * d_3),
    )
    model_terms(c, q, nu, wrench)
    _feedback(c, law, nu, sp, omega_d, a_d, k, memory, wrench)
    return bounded == theta


@equation
def _linear(q, nu, sp, dt, law, c, memory, wrench):  # type: ignore[no-untyped-def]
    phi, theta, psi = euler_from_quaternion(q)
    rate, a = sp.attitude_rate, sp.attitude_acceleration
    eta, eta_d, wanted = (phi, theta, psi), sp.attitude, memory.wanted
    for i in range(3):
        wanted[i] = sp.acceleration[i]
        wanted[3 + i] = a[i] - law.k_I * wrapped(eta[i] - eta_d[i])
        memory.terms[i] = nu[i] - sp.velocity[i]
        memory.terms[3 + i] = nu[3 + i] - rate[i]
    for i in range(6):
        for j in range(6):
            wanted[i] -= law.K_P[i, j] * memory.terms[j]
    for i in range(6):
        wrench[i] = law.level[i] + law.slope[i, 0] * phi + law.slope[i, 1] * theta + law.slope[i, 2] * psi
        for j in range(6):
            wrench[i] += law.D_L[i, j] * nu[j] + law.M[i, j] * wanted[j]
    return True


@equation
def _pid(q, nu, sp, dt, law, c, memory, wrench):  # type: ignore[no-untyped-def]
    q_e = _chosen(quaternion_error(q, sp), memory, law.hysteresis)
    nu_2 = (nu[3], nu[4], nu[5])
    omega_d = desired_rates(q_e, nu_2, sp)[0]
    for i in range(6):
        error = sp.velocity[i] - nu[i] if i < 3 else -2.0 * q_e[i - 2]
        wrench[i] = law.proportional[i] * error + law.integral[i] * memory.integral[i]
        if i >= 3:
            wrench[i] += law.derivative[i - 3] * (omega_d[i - 3] - nu_2[i - 3])
        cut = min(max(wrench[i], -law.largest[i]), law.largest[i])
        too_much = (wrench[i] - cut) * error > 0.0 or (
            abs(memory.shortfall[i]) > _SHORT and memory.shortfall[i] * error > 0.0
        )
        if not too_much:
            memory.integral[i] += dt * error
        wrench[i] = cut
    return True


_LAWS: dict[type, Equation] = {QuaternionLaw: _quaternion, EulerLaw: _euler, LinearLaw: _linear, PidLaw: _pid}


def law_wrench(q, nu, sp, dt, law, c, memory, wrench):  # type: ignore[no-untyped-def]
    """Fill wrench (6,) [N, N m] by the law of this class; return whether it is within what the law is for.

    q (4,), nu (6,): state; sp: `VehicleSetPoint`; dt: period [s]; c: the vehicle's coefficients; memory:
    `OuterMemory`, changed in place.
    """
    return _LAWS[type(law)](q, nu, sp, dt, law, c, memory, wrench)


@overload(law_wrench, inline="always")
def _compile_law_wrench(q, nu, sp, dt, law, c, memory, wrench):  # type: ignore[no-untyped-def]
    chosen = _LAWS[law.instance_class]
    return lambda q, nu, sp, dt, law, c, memory, wrench: chosen(q, nu, sp, dt, law, c, memory, wrench)
