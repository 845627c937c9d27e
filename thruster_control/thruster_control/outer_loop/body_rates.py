r"""Body rates and their rates of change from those of roll, pitch, yaw; regular at every attitude.

    nu_2 = J_2^-1 deta/dt,    dnu_2/dt = J_2^-1 d2eta/dt2 + (dJ_2^-1/dt) deta/dt

The second equals J_2^-1 (d2eta/dt2 - (dJ_2/dt) nu_2), without J_2, which does not exist at 90 degrees of pitch.
"""

import math

from thruster_model.compilation import equation
from thruster_model.equations.attitude import euler_rate_matrix_inverse, matrix_times

__all__ = ["body_acceleration", "body_rates"]


@equation
def body_rates(angles, rate):  # type: ignore[no-untyped-def]
    """Return (p, q, r) = J_2^-1 rate [rad/s] at the angles (roll, pitch, yaw) [rad]."""
    return matrix_times(euler_rate_matrix_inverse(angles), rate)


@equation
def body_acceleration(angles, turning, rate, acceleration):  # type: ignore[no-untyped-def]
    """Return J_2^-1 acceleration + (dJ_2^-1/dt) rate [rad/s^2], while the angles change at `turning` [rad/s]."""
    s_1, c_1, s_2, c_2 = math.sin(angles[0]), math.cos(angles[0]), math.sin(angles[1]), math.cos(angles[1])
    phi_dot, theta_dot = turning[0], turning[1]
    x, y, z = body_rates(angles, acceleration)
    return (
        x - rate[2] * c_2 * theta_dot,
        y - rate[1] * s_1 * phi_dot + rate[2] * (c_1 * c_2 * phi_dot - s_1 * s_2 * theta_dot),
        z - rate[1] * c_1 * phi_dot - rate[2] * (s_1 * c_2 * phi_dot + c_1 * s_2 * theta_dot),
    )
