r"""From one reading of the IMU to the next: belief and covariance of `navigation`.

P <- Phi P Phi^T + Q,   Phi = I + F dt with the F of the errors' equations, whose blocks are put in one by one.
"""

from math import isfinite

from thruster_estimation.navigation_belief import ERRORS
from thruster_model.compilation import equation
from thruster_model.equations.attitude import quaternion_product, rotated
from thruster_model.equations.rotation_vector import rotation

__all__ = ["axes", "propagated"]


@equation
def axes(q):  # type: ignore[no-untyped-def]
    """Return the axes x, y, z that a quaternion turns the reference's into."""
    return rotated(q, (1.0, 0.0, 0.0)), rotated(q, (0.0, 1.0, 0.0)), rotated(q, (0.0, 0.0, 1.0))


@equation
def propagated(b, heard, h, s):  # type: ignore[no-untyped-def]
    """Return (position, velocity, attitude, P, rate, force, known) after `h` [s].

    rate, force: of the IMU now, held where it tells nothing (known: False).
    """
    rate = (heard.rate_x, heard.rate_y, heard.rate_z)
    force = (heard.force_x, heard.force_y, heard.force_z)
    known = isfinite(rate[0] + rate[1] + rate[2] + force[0] + force[1] + force[2])
    if not known:
        rate, force = b.rate, b.force
    turning = (
        0.5 * (b.rate[0] + rate[0]) - b.gyro_bias[0],
        0.5 * (b.rate[1] + rate[1]) - b.gyro_bias[1],
        0.5 * (b.rate[2] + rate[2]) - b.gyro_bias[2],
    )
    f = (
        0.5 * (b.force[0] + force[0]) - b.force_bias[0],
        0.5 * (b.force[1] + force[1]) - b.force_bias[1],
        0.5 * (b.force[2] + force[2]) - b.force_bias[2],
    )
    omega = rotated(s.imu_rotation, turning)
    halfway = quaternion_product(b.attitude, rotation((0.5 * h * omega[0], 0.5 * h * omega[1], 0.5 * h * omega[2])))
    attitude = quaternion_product(b.attitude, rotation((h * omega[0], h * omega[1], h * omega[2])))
    sensing = quaternion_product(halfway, s.imu_rotation)
    felt = rotated(sensing, f)
    velocity = (b.velocity[0] + h * felt[0], b.velocity[1] + h * felt[1], b.velocity[2] + h * (felt[2] + s.gravity))
    position = (
        b.position[0] + 0.5 * h * (b.velocity[0] + velocity[0]),
        b.position[1] + 0.5 * h * (b.velocity[1] + velocity[1]),
        b.position[2] + 0.5 * h * (b.velocity[2] + velocity[2]),
    )
    P = b.P.copy()
    x, y, z = axes(sensing)
    _spread(P, h, felt, x, y, z)
    of_rate = (h * (s.gyro_noise if known else s.unknown_rate)) ** 2
    of_force = (h * (s.force_noise if known else s.unknown_force)) ** 2
    for i in range(3):
        P[3 + i, 3 + i] += of_force
        P[6 + i, 6 + i] += of_rate
        P[9 + i, 9 + i] += s.gyro_walk**2 * h
        P[12 + i, 12 + i] += s.force_walk**2 * h
    return position, velocity, attitude, P, rate, force, known


@equation
def _spread(P, h, f, x, y, z):  # type: ignore[no-untyped-def]
    """Turn P into Phi P Phi^T; f: specific force, x, y, z: axes of the IMU, both in the earth frame."""
    for j in range(ERRORS):
        v0, v1, v2, a0, a1, a2 = P[3, j], P[4, j], P[5, j], P[6, j], P[7, j], P[8, j]
        g0, g1, g2, b0, b1, b2 = P[9, j], P[10, j], P[11, j], P[12, j], P[13, j], P[14, j]
        P[3, j] = v0 - h * (f[1] * a2 - f[2] * a1 + x[0] * b0 + y[0] * b1 + z[0] * b2)
        P[0, j] += 0.5 * h * (v0 + P[3, j])
        P[4, j] = v1 - h * (f[2] * a0 - f[0] * a2 + x[1] * b0 + y[1] * b1 + z[1] * b2)
        P[1, j] += 0.5 * h * (v1 + P[4, j])
        P[5, j] = v2 - h * (f[0] * a1 - f[1] * a0 + x[2] * b0 + y[2] * b1 + z[2] * b2)
        P[2, j] += 0.5 * h * (v2 + P[5, j])
        P[6, j] = a0 - h * (x[0] * g0 + y[0] * g1 + z[0] * g2)
        P[7, j] = a1 - h * (x[1] * g0 + y[1] * g1 + z[1] * g2)
        P[8, j] = a2 - h * (x[2] * g0 + y[2] * g1 + z[2] * g2)
    for i in range(ERRORS):
        v0, v1, v2, a0, a1, a2 = P[i, 3], P[i, 4], P[i, 5], P[i, 6], P[i, 7], P[i, 8]
        g0, g1, g2, b0, b1, b2 = P[i, 9], P[i, 10], P[i, 11], P[i, 12], P[i, 13], P[i, 14]
        P[i, 3] = v0 - h * (f[1] * a2 - f[2] * a1 + x[0] * b0 + y[0] * b1 + z[0] * b2)
        P[i, 0] += 0.5 * h * (v0 + P[i, 3])
        P[i, 4] = v1 - h * (f[2] * a0 - f[0] * a2 + x[1] * b0 + y[1] * b1 + z[1] * b2)
        P[i, 1] += 0.5 * h * (v1 + P[i, 4])
        P[i, 5] = v2 - h * (f[0] * a1 - f[1] * a0 + x[2] * b0 + y[2] * b1 + z[2] * b2)
        P[i, 2] += 0.5 * h * (v2 + P[i, 5])
        P[i, 6] = a0 - h * (x[0] * g0 + y[0] * g1 + z[0] * g2)
        P[i, 7] = a1 - h * (x[1] * g0 + y[1] * g1 + z[1] * g2)
        P[i, 8] = a2 - h * (x[2] * g0 + y[2] * g1 + z[2] * g2)
