r"""Attitude of a body: unit quaternions and Euler angles 3-2-1.

q = (w, x, y, z), |q| = 1, turns body axes into earth axes (north, east, down); angles (phi, theta, psi) [rad] are roll,
pitch, yaw of the same turn: R = R_z(psi) R_y(theta) R_x(phi), J_1 of (2.4). With omega = (p, q, r) [rad/s], the
body's rate in body axes:

dq/dt = 1/2 q * (0, omega)
d(phi, theta, psi)/dt = J_2 omega                     J_2 of (2.5); it does not exist at theta = +-90 deg

Everything is a tuple of numbers, or of arrays of one shape: kernels and Python share the code.
"""

import numpy as np

from thruster_model.compilation import equation

__all__ = [
    "conjugate",
    "cross",
    "euler_from_quaternion",
    "euler_rate_matrix",
    "euler_rate_matrix_derivative",
    "euler_rate_matrix_inverse",
    "matrix_times",
    "normalised",
    "quaternion_from_euler",
    "quaternion_product",
    "quaternion_rate",
    "rotated",
    "rotated_back",
    "wrapped",
]

_VERTICAL = 1.0 - 1e-14  # |sin theta| from which roll and yaw turn about one axis


@equation
def quaternion_from_euler(angles):  # type: ignore[no-untyped-def]
    """Return q of the angles (phi, theta, psi) [rad]."""
    phi, theta, psi = angles
    c1, s1 = np.cos(0.5 * phi), np.sin(0.5 * phi)
    c2, s2 = np.cos(0.5 * theta), np.sin(0.5 * theta)
    c3, s3 = np.cos(0.5 * psi), np.sin(0.5 * psi)
    return (
        c1 * c2 * c3 + s1 * s2 * s3,
        s1 * c2 * c3 - c1 * s2 * s3,
        c1 * s2 * c3 + s1 * c2 * s3,
        c1 * c2 * s3 - s1 * s2 * c3,
    )


@equation
def euler_from_quaternion(q):  # type: ignore[no-untyped-def]
    """Return (phi, theta, psi) [rad], theta within +-90 deg; there, where only one turn is left, phi is 0."""
    w, x, y, z = q
    sine = 2.0 * (w * y - z * x)
    b, c = 2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)
    tilted = 1.0 * (np.abs(sine) <= _VERTICAL)
    theta = np.arctan2(sine, np.sqrt(b * b + c * c))
    psi = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    turn = np.arctan2(2.0 * (w * z - x * y), 1.0 - 2.0 * (x * x + z * z))
    return tilted * np.arctan2(b, c), theta, tilted * psi + (1.0 - tilted) * turn


@equation
def quaternion_product(a, b):  # type: ignore[no-untyped-def]
    """Return a * b: the turn b, then, in the axes before it, the turn a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


@equation
def conjugate(q):  # type: ignore[no-untyped-def]
    """Return the inverse turn."""
    w, x, y, z = q
    return w, -x, -y, -z


@equation
def normalised(q):  # type: ignore[no-untyped-def]
    """Return q / |q|."""
    w, x, y, z = q
    scale = 1.0 / np.sqrt(w * w + x * x + y * y + z * z)
    return w * scale, x * scale, y * scale, z * scale


@equation
def cross(a, b):  # type: ignore[no-untyped-def]
    """Return a x b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@equation
def rotated(q, x):  # type: ignore[no-untyped-def]
    """Return the vector x of body axes in earth axes: J_1 x."""
    axis = (q[1], q[2], q[3])
    t = cross(axis, x)
    s = cross(axis, t)
    return (
        x[0] + 2.0 * (q[0] * t[0] + s[0]),
        x[1] + 2.0 * (q[0] * t[1] + s[1]),
        x[2] + 2.0 * (q[0] * t[2] + s[2]),
    )


@equation
def rotated_back(q, x):  # type: ignore[no-untyped-def]
    """Return the vector x of earth axes in body axes: J_1^T x."""
    return rotated(conjugate(q), x)


@equation
def quaternion_rate(q, omega):  # type: ignore[no-untyped-def]
    """Return dq/dt [1/s] at the body's rate omega = (p, q, r) [rad/s], in body axes."""
    w, x, y, z = q
    a, b, c = omega
    return (
        -0.5 * (x * a + y * b + z * c),
        0.5 * (w * a + y * c - z * b),
        0.5 * (w * b + z * a - x * c),
        0.5 * (w * c + x * b - y * a),
    )


@equation
def euler_rate_matrix(angles):  # type: ignore[no-untyped-def]
    """Return J_2 as three rows: d(phi, theta, psi)/dt = J_2 omega."""
    phi, theta, _ = angles
    c, s, per_cosine, tangent = np.cos(phi), np.sin(phi), 1.0 / np.cos(theta), np.tan(theta)
    one, zero = 1.0 + 0.0 * phi, 0.0 * phi
    return (one, s * tangent, c * tangent), (zero, c, -s), (zero, s * per_cosine, c * per_cosine)


@equation
def euler_rate_matrix_inverse(angles):  # type: ignore[no-untyped-def]
    """Return the inverse of J_2 as three rows; it exists at every attitude."""
    phi, theta, _ = angles
    c, s, cosine, sine = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    one, zero = 1.0 + 0.0 * phi, 0.0 * phi
    return (one, zero, -sine), (zero, c, s * cosine), (zero, -s, c * cosine)


@equation
def euler_rate_matrix_derivative(angles, rates):  # type: ignore[no-untyped-def]
    """Return dJ_2/dt [1/s] as three rows, at the rates d(phi, theta, psi)/dt [rad/s]."""
    phi, theta, _ = angles
    phi_dot, theta_dot, _ = rates
    c, s, per_cosine, tangent = np.cos(phi), np.sin(phi), 1.0 / np.cos(theta), np.tan(theta)
    tangent_dot = theta_dot * per_cosine * per_cosine
    per_cosine_dot = theta_dot * per_cosine * tangent
    zero = 0.0 * phi
    return (
        (zero, c * phi_dot * tangent + s * tangent_dot, -s * phi_dot * tangent + c * tangent_dot),
        (zero, -s * phi_dot, -c * phi_dot),
        (zero, c * phi_dot * per_cosine + s * per_cosine_dot, -s * phi_dot * per_cosine + c * per_cosine_dot),
    )


@equation
def matrix_times(rows, x):  # type: ignore[no-untyped-def]
    """Return the product of a matrix of three rows and a vector."""
    first, second, third = rows
    return (
        first[0] * x[0] + first[1] * x[1] + first[2] * x[2],
        second[0] * x[0] + second[1] * x[1] + second[2] * x[2],
        third[0] * x[0] + third[1] * x[1] + third[2] * x[2],
    )


@equation
def wrapped(angle):  # type: ignore[no-untyped-def]
    """Return the angle [rad] less whole turns, within [-pi, pi)."""
    return angle - 2.0 * np.pi * np.floor((angle + np.pi) / (2.0 * np.pi))
