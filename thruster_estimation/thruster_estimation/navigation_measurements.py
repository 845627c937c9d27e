r"""What each sensor would tell of a belief, how that hangs on the belief's errors, and what a measurement does to them.

innovation y = measured - told,  row h of its errors,  variance r of the sensor
S = h P h^T + r,   NIS = (y - h dx)^2 / S,   dx += P h^T (y - h dx) / S,   P -= P h^T h P / S
"""

from math import isfinite, nan, sqrt

import numpy as np

from thruster_estimation.navigation_belief import ERRORS
from thruster_estimation.navigation_propagation import axes
from thruster_model.compilation import equation
from thruster_model.equations.attitude import conjugate, cross, quaternion_product, rotated, rotated_back
from thruster_model.equations.rotation_vector import rotation_vector

__all__ = ["attitude_rows", "depth_row", "largest_share", "taken_in", "velocity_rows"]


@equation
def attitude_rows(heard, attitude, s, y, H, r):  # type: ignore[no-untyped-def]
    """Fill the first three of y [rad], H and r with the attitude; NaN in y: not measured, or no unit quaternion."""
    size = sqrt(heard.w * heard.w + heard.x * heard.x + heard.y * heard.y + heard.z * heard.z)
    if not abs(size - 1.0) < 0.1:
        return
    told = (heard.w / size, heard.x / size, heard.y / size, heard.z / size)
    body = quaternion_product(told, conjugate(s.imu_rotation))
    difference = rotation_vector(quaternion_product(body, conjugate(attitude)))
    for i in range(3):
        y[i], r[i], H[i, 6 + i] = difference[i], s.attitude_noise**2, 1.0


@equation
def velocity_rows(heard, velocity, attitude, rate, gyro_bias, s, y, H, r):  # type: ignore[no-untyped-def]
    """Fill rows 3 to 5 of y [m/s], H and r with the velocity log; rate: of the IMU, its bias still in it [rad/s]."""
    measured = (heard.velocity_x, heard.velocity_y, heard.velocity_z)
    if not isfinite(measured[0] + measured[1] + measured[2]):
        return
    arm = (
        s.velocity_position[0] - s.imu_position[0],
        s.velocity_position[1] - s.imu_position[1],
        s.velocity_position[2] - s.imu_position[2],
    )
    omega = rotated(s.imu_rotation, (rate[0] - gyro_bias[0], rate[1] - gyro_bias[1], rate[2] - gyro_bias[2]))
    lever = cross(omega, arm)
    in_body, in_earth = axes(s.velocity_rotation), axes(quaternion_product(attitude, s.velocity_rotation))
    for i in range(3):
        b, e = in_body[i], in_earth[i]
        told = e[0] * velocity[0] + e[1] * velocity[1] + e[2] * velocity[2]
        told += b[0] * lever[0] + b[1] * lever[1] + b[2] * lever[2]
        tilt = cross(e, velocity)
        turn = rotated_back(s.imu_rotation, cross(b, arm))
        y[3 + i] = measured[i] - told
        r[3 + i] = s.velocity_noise**2 + s.gyro_noise**2 * (turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
        for j in range(3):
            H[3 + i, 3 + j], H[3 + i, 6 + j], H[3 + i, 9 + j] = e[j], tilt[j], turn[j]


@equation
def depth_row(heard, position, attitude, s, y, H, r):  # type: ignore[no-untyped-def]
    """Fill row 6 of y [m], H and r with the depth."""
    arm = (
        s.depth_position[0] - s.imu_position[0],
        s.depth_position[1] - s.imu_position[1],
        s.depth_position[2] - s.imu_position[2],
    )
    lever = rotated(attitude, arm)
    y[6], r[6] = heard.depth - position[2] - lever[2], s.depth_noise**2
    H[6, 2], H[6, 6], H[6, 7] = 1.0, lever[1], -lever[0]


@equation
def largest_share(P, y, H, r, first, after):  # type: ignore[no-untyped-def]
    """Return the largest y^2 / S of rows `first` to before `after`; NaN where one of them is not measured."""
    largest = 0.0
    for i in range(first, after):
        if not isfinite(y[i]):
            return nan
        S = r[i]
        for j in range(ERRORS):
            if H[i, j] != 0.0:
                for k in range(ERRORS):
                    S += H[i, j] * P[j, k] * H[i, k]
        largest = max(largest, y[i] * y[i] / S)
    return largest


@equation
def taken_in(P, dx, y, h, r):  # type: ignore[no-untyped-def]
    """Change P and the errors dx (15,) by a measurement of one axis, its row h (15,); return its NIS."""
    Ph = np.zeros(ERRORS)
    for j in range(ERRORS):
        if h[j] != 0.0:
            for i in range(ERRORS):
                Ph[i] += P[i, j] * h[j]
    S, error = r, y
    for j in range(ERRORS):
        S += h[j] * Ph[j]
        error -= h[j] * dx[j]
    for i in range(ERRORS):
        gain = Ph[i] / S
        dx[i] += gain * error
        for j in range(ERRORS):
            P[i, j] -= gain * Ph[j]
    return error * error / S
