r"""Rotation vectors: a turn by |x| [rad] about the axis x/|x|, as a unit quaternion (w, x, y, z) and back.

q = (cos(|x| / 2), sin(|x| / 2) x / |x|),     x = 2 atan2(|q_v|, q_w) q_v / |q_v|,  of at most pi
"""

from math import atan2, cos, sin, sqrt

from thruster_model.compilation import equation

__all__ = ["rotation", "rotation_vector"]

_SMALL = 1e-9


@equation
def rotation(x):  # type: ignore[no-untyped-def]
    """Return the quaternion of a rotation vector (x, y, z) [rad]."""
    angle = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2])
    s = 0.5 if angle < _SMALL else sin(0.5 * angle) / angle
    return (cos(0.5 * angle), s * x[0], s * x[1], s * x[2])


@equation
def rotation_vector(q):  # type: ignore[no-untyped-def]
    """Return the rotation vector (x, y, z) [rad] of a quaternion; both signs of it are the same turn."""
    sign = -1.0 if q[0] < 0.0 else 1.0
    size = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    s = 2.0 * sign if size < _SMALL else 2.0 * sign * atan2(size, sign * q[0]) / size
    return (s * q[1], s * q[2], s * q[3])
