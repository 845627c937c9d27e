r"""Attitudes as unit quaternions (w, x, y, z), body to earth, and as Euler angles 3-2-1 (roll, pitch, yaw) [rad].

q = q_psi q_theta q_phi,    (p, q, r) = J_2^-1(phi, theta) d(phi, theta, psi)/dt

J_2^-1 = [[1, 0, -sin theta], [0, cos phi, sin phi cos theta], [0, -sin phi, cos phi cos theta]]
"""

import math

from thruster_model.compilation import equation

__all__ = ["body_acceleration", "body_rates", "euler_rates", "from_euler", "relative", "to_euler", "turned", "wrapped"]


@equation
def from_euler(phi, theta, psi):  # type: ignore[no-untyped-def]
    """Return the quaternion of roll, pitch, yaw."""
    c_1, s_1 = math.cos(0.5 * phi), math.sin(0.5 * phi)
    c_2, s_2 = math.cos(0.5 * theta), math.sin(0.5 * theta)
    c_3, s_3 = math.cos(0.5 * psi), math.sin(0.5 * psi)
    return (
        c_1 * c_2 * c_3 + s_1 * s_2 * s_3,
        s_1 * c_2 * c_3 - c_1 * s_2 * s_3,
        c_1 * s_2 * c_3 + s_1 * c_2 * s_3,
        c_1 * c_2 * s_3 - s_1 * s_2 * c_3,
    )


@equation
def to_euler(q):  # type: ignore[no-untyped-def]
    """Return (roll, pitch, yaw) of a unit quaternion; at |pitch| = 90 degrees roll and yaw are one angle."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    phi = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    theta = math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0))
    psi = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return phi, theta, psi


@equation
def relative(q_d, q):  # type: ignore[no-untyped-def]
    """Return q_d* q: the attitude q as seen from q_d, of unit length."""
    w = q_d[0] * q[0] + q_d[1] * q[1] + q_d[2] * q[2] + q_d[3] * q[3]
    x = q_d[0] * q[1] - q_d[1] * q[0] - q_d[2] * q[3] + q_d[3] * q[2]
    y = q_d[0] * q[2] - q_d[2] * q[0] - q_d[3] * q[1] + q_d[1] * q[3]
    z = q_d[0] * q[3] - q_d[3] * q[0] - q_d[1] * q[2] + q_d[2] * q[1]
    size = math.sqrt(w * w + x * x + y * y + z * z)
    return w / size, x / size, y / size, z / size


@equation
def turned(q, a):  # type: ignore[no-untyped-def]
    """Return the vector `a` of the frame that q leads to in the axes of the one that q turns: R(q)^T a."""
    w, x, y, z = q[0], -q[1], -q[2], -q[3]
    t_1, t_2, t_3 = 2.0 * (y * a[2] - z * a[1]), 2.0 * (z * a[0] - x * a[2]), 2.0 * (x * a[1] - y * a[0])
    return (
        a[0] + w * t_1 + y * t_3 - z * t_2,
        a[1] + w * t_2 + z * t_1 - x * t_3,
        a[2] + w * t_3 + x * t_2 - y * t_1,
    )


@equation
def body_rates(phi, theta, rate):  # type: ignore[no-untyped-def]
    """Return (p, q, r) = J_2^-1 rate [rad/s] for the rates of roll, pitch, yaw; regular everywhere."""
    s_1, c_1, s_2, c_2 = math.sin(phi), math.cos(phi), math.sin(theta), math.cos(theta)
    return (
        rate[0] - rate[2] * s_2,
        rate[1] * c_1 + rate[2] * s_1 * c_2,
        -rate[1] * s_1 + rate[2] * c_1 * c_2,
    )


@equation
def body_acceleration(phi, theta, turning, rate, acceleration):  # type: ignore[no-untyped-def]
    """Return J_2^-1 acceleration + (d J_2^-1/dt) rate [rad/s^2], where phi and theta change at turning[0], turning[1].

    With `turning` = J_2 nu_2 this is J_2^-1 (acceleration - (dJ_2/dt) J_2^-1 rate).
    """
    s_1, c_1, s_2, c_2 = math.sin(phi), math.cos(phi), math.sin(theta), math.cos(theta)
    phi_dot, theta_dot = turning[0], turning[1]
    x, y, z = body_rates(phi, theta, acceleration)
    return (
        x - rate[2] * c_2 * theta_dot,
        y - rate[1] * s_1 * phi_dot + rate[2] * (c_1 * c_2 * phi_dot - s_1 * s_2 * theta_dot),
        z - rate[1] * c_1 * phi_dot - rate[2] * (s_1 * c_2 * phi_dot + c_1 * s_2 * theta_dot),
    )


@equation
def euler_rates(phi, theta, nu_2):  # type: ignore[no-untyped-def]
    """Return J_2 nu_2 [rad/s] of (2.5), the rates of roll, pitch, yaw; without bound towards 90 degrees of pitch."""
    s_1, c_1, c_2 = math.sin(phi), math.cos(phi), math.cos(theta)
    about = (s_1 * nu_2[1] + c_1 * nu_2[2]) / c_2
    return nu_2[0] + about * math.sin(theta), c_1 * nu_2[1] - s_1 * nu_2[2], about


@equation
def wrapped(angle):  # type: ignore[no-untyped-def]
    """Return the angle [rad] in [-pi, pi)."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)
