r"""Attitude, velocity, depth and the IMU's biases from IMU, velocity log and depth sensor: an error-state filter.

State, of the IMU's place, in the earth frame (north, east, down): p, v, attitude q, biases b_g, b_a in the IMU's axes.
With R of the IMU's axes in the earth frame, between two readings of the IMU at their mean, exact for constant ones:

q <- q exp(omega dt / 2)           omega = gyro - b_g
v <- v + (R (f - b_a) + g) dt      f: specific force;   p <- p + dt (v before + v after) / 2

True p, v, b = belief + errors dp, dv, db;   true attitude = exp(dtheta / 2) q, dtheta about the earth's axes:

dp' = dv (mean of before and after),   dv' = -[R f]x dtheta - R db_a + noise,   dtheta' = -R db_g + noise,   db' = noise

A measurement is taken in axis by axis (the same as at once, its axes being independent), errors are put in at the end:

attitude    2 vec(q_measured q^-1) = dtheta
velocity    R_l^T v + (omega x r) in the log's axes,   r from the IMU to the log
depth       p_z + (R_b r)_z,                           r from the IMU to the depth sensor

Without velocity log a rest of `still_velocity` is believed, once in `still_time`, which bounds what integration of the
specific force makes of tilt and bias. North and east are dead reckoning: their deviations grow.
"""

from math import isfinite, nan, sqrt

import numpy as np

from thruster_estimation.navigation_belief import (
    ERRORS,
    Heard,
    NavigationBelief,
    NavigationInnovation,
    NavigationStatus,
)
from thruster_estimation.navigation_measurements import (
    attitude_rows,
    depth_row,
    largest_share,
    taken_in,
    velocity_rows,
)
from thruster_estimation.navigation_propagation import propagated
from thruster_model.compilation import equation
from thruster_model.equations.attitude import conjugate, quaternion_product, rotated
from thruster_model.equations.rotation_vector import rotation

__all__ = ["begun", "navigation_first", "navigation_step"]

_USED, _GATED = int(NavigationStatus.USED_ATTITUDE), int(NavigationStatus.GATED_ATTITUDE)
_STALE, _REOPENED = int(NavigationStatus.STALE_ATTITUDE), int(NavigationStatus.REOPENED)
_STALE_VELOCITY = int(NavigationStatus.STALE_VELOCITY)
_NO_RATES, _BAD_PERIOD = int(NavigationStatus.NO_RATES), int(NavigationStatus.BAD_PERIOD)
_RESTARTED, _PREDICTED = int(NavigationStatus.RESTARTED), int(NavigationStatus.PREDICTED)
_ROWS = (0, 3, 6, 7)
_MEASURED = (6, 3, 2)
_AXES = (3, 3, 1)


@equation
def begun(heard, settings, status):  # type: ignore[no-untyped-def]
    """Return the belief before the first step: at rest at the origin, with attitude and depth of the first reading.

    heard: `Heard`; settings: `checked_navigation` ones; status: flags, 0 at the start.
    """
    s = settings
    size = sqrt(heard.w * heard.w + heard.x * heard.x + heard.y * heard.y + heard.z * heard.z)
    known = abs(size - 1.0) < 0.1
    attitude, tilt = (1.0, 0.0, 0.0, 0.0), s.attitude_deviation
    if known:
        told = (heard.w / size, heard.x / size, heard.y / size, heard.z / size)
        attitude, tilt = quaternion_product(told, conjugate(s.imu_rotation)), s.attitude_noise
    to_imu, to_depth = rotated(attitude, s.imu_position), rotated(attitude, s.depth_position)
    deep = isfinite(heard.depth)
    z = heard.depth - to_depth[2] if deep else 0.0
    P = np.zeros((ERRORS, ERRORS))
    P[2, 2] = (s.depth_noise if deep else s.depth_deviation) ** 2
    for i in range(3):
        P[3 + i, 3 + i] = s.velocity_deviation**2
        P[6 + i, 6 + i] = tilt**2
        P[9 + i, 9 + i] = s.gyro_bias_deviation**2
        P[12 + i, 12 + i] = s.force_bias_deviation**2
    rate = (heard.rate_x, heard.rate_y, heard.rate_z)
    force = (heard.force_x, heard.force_y, heard.force_z)
    if not isfinite(rate[0] + rate[1] + rate[2] + force[0] + force[1] + force[2]):
        rate, force = (0.0, 0.0, 0.0), (0.0, 0.0, -s.gravity)
    nothing = (0.0, 0.0, 0.0)
    position = (to_imu[0], to_imu[1], z + to_imu[2])
    return NavigationBelief(
        position, nothing, attitude, nothing, nothing, P, rate, force, status, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    )


@equation
def navigation_step(belief, heard, dt, settings):  # type: ignore[no-untyped-def]
    """Return (NavigationBelief, NavigationInnovation) at the instant of `heard`, `dt` [s] after that of `belief`.

    belief: `NavigationBelief`, at first of `begun`; heard: `Heard`; settings: `checked_navigation` ones.
    """
    s = settings
    usable = isfinite(dt) and dt >= 0.0
    h = dt if usable else 0.0
    position, velocity, attitude, P, rate, force, known = propagated(belief, heard, h, s)
    flags = (0 if usable else _BAD_PERIOD) | (0 if known else _NO_RATES)
    y, H, r = np.full(7, nan), np.zeros((7, ERRORS)), np.zeros(7)
    attitude_rows(heard, attitude, s, y, H, r)
    velocity_rows(heard, velocity, attitude, rate, belief.gyro_bias, s, y, H, r)
    depth_row(heard, position, attitude, s, y, H, r)

    dx = np.zeros(ERRORS)
    nis, unseen, shut = np.full(3, nan), np.zeros(3), np.zeros(3)
    unseen[0], unseen[1], unseen[2] = belief.unseen_attitude + h, belief.unseen_velocity + h, belief.unseen_depth + h
    shut[0], shut[1], shut[2] = belief.shut_attitude, belief.shut_velocity, belief.shut_depth
    for k in range(3):
        share = largest_share(P, y, H, r, _ROWS[k], _ROWS[k + 1])
        if not isfinite(share):
            continue
        if share > s.gate:
            if shut[k] < s.patience:
                shut[k] += h
                flags |= _GATED << k
                continue
            flags |= _REOPENED
            for i in range(_AXES[k]):
                P[_MEASURED[k] + i, _MEASURED[k] + i] += np.max(y[_ROWS[k] : _ROWS[k + 1]] ** 2)
        nis[k] = 0.0
        for i in range(_ROWS[k], _ROWS[k + 1]):
            nis[k] += taken_in(P, dx, y[i], H[i], r[i])
        unseen[k], shut[k] = 0.0, 0.0
        flags |= _USED << k
    for k in range(3):
        flags |= _STALE << k if unseen[k] > s.stale else 0
    flags |= 0 if flags & (7 * _USED) else _PREDICTED
    if flags & _STALE_VELOCITY and h > 0.0:
        at_rest = np.zeros(ERRORS)
        for i in range(3):
            at_rest[3 + i] = 1.0
            taken_in(P, dx, -velocity[i], at_rest, s.still_velocity**2 * s.still_time / h)
            at_rest[3 + i] = 0.0

    innovation = NavigationInnovation(y[0], y[1], y[2], y[3], y[4], y[5], y[6], nis[0], nis[1], nis[2])
    turned = quaternion_product(rotation((dx[6], dx[7], dx[8])), attitude)
    size = sqrt(turned[0] ** 2 + turned[1] ** 2 + turned[2] ** 2 + turned[3] ** 2)
    sound = isfinite(size) and size > 0.0
    for i in range(ERRORS):
        sound = sound and P[i, i] >= 0.0 and isfinite(np.sum(P[i])) and isfinite(dx[i])
    sound = sound and isfinite(position[0] + position[1] + position[2] + velocity[0] + velocity[1] + velocity[2])
    if not sound:
        return begun(heard, s, flags | _RESTARTED), innovation
    after = NavigationBelief(
        (position[0] + dx[0], position[1] + dx[1], position[2] + dx[2]),
        (velocity[0] + dx[3], velocity[1] + dx[4], velocity[2] + dx[5]),
        (turned[0] / size, turned[1] / size, turned[2] / size, turned[3] / size),
        (belief.gyro_bias[0] + dx[9], belief.gyro_bias[1] + dx[10], belief.gyro_bias[2] + dx[11]),
        (belief.force_bias[0] + dx[12], belief.force_bias[1] + dx[13], belief.force_bias[2] + dx[14]),
        P,
        rate,
        force,
        flags,
        unseen[0],
        unseen[1],
        unseen[2],
        shut[0],
        shut[1],
        shut[2],
    )
    return after, innovation


@equation
def navigation_first(heard, settings):  # type: ignore[no-untyped-def]
    """Return (NavigationBelief, NavigationInnovation) at the first instant, where each reading counts once."""
    belief = begun(heard, settings, 0)
    rest = Heard(
        nan, nan, nan, nan, heard.rate_x, heard.rate_y, heard.rate_z, heard.force_x, heard.force_y, heard.force_z,
        heard.velocity_x, heard.velocity_y, heard.velocity_z, nan,
    )  # fmt: skip
    return navigation_step(belief, rest, 0.0, settings)
