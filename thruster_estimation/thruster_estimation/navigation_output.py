r"""What the vehicle does according to a belief: pose and velocity of the body's origin, with their covariances.

With R of the body in the earth frame, r the place of the IMU, R_i its axes, errors as in `navigation`:

p_o = p - R r             dp_o = dp + [R r]x dtheta
omega = R_i (gyro - b_g)  domega = -R_i (db_g + gyro noise)
nu_1 = R^T v - omega x r  dnu_1 = R^T dv + R^T [v]x dtheta + [r]x domega
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_estimation.navigation import begun, navigation_first, navigation_step
from thruster_estimation.navigation_belief import ERRORS, Heard, NavigationBelief, NavigationSettings
from thruster_estimation.navigation_propagation import axes
from thruster_model.compilation import compiled, equation
from thruster_model.equations.attitude import cross, rotated, rotated_back

__all__ = [
    "NavigationHistory", "NavigationOutput", "compiled_begin", "compiled_first", "compiled_navigation",
    "compiled_output", "navigate", "navigation_motion", "navigation_output",
]  # fmt: skip

Array = NDArray[np.float64]


class NavigationOutput(NamedTuple):
    """Motion of the body.

    Attributes:
        position: of its origin in the earth frame, from the start (north, east) and the surface [m].
        attitude: unit quaternion (w, x, y, z), body in the earth frame.
        velocity: nu (6), in body axes [m/s, rad/s].
        pose_covariance: of position [m^2] and turns about the earth's axes [rad^2], shape (6, 6).
        velocity_covariance: of nu, shape (6, 6).
    """

    position: tuple[float, float, float]
    attitude: tuple[float, float, float, float]
    velocity: tuple[float, float, float, float, float, float]
    pose_covariance: Array
    velocity_covariance: Array


@equation
def navigation_motion(belief, settings):  # type: ignore[no-untyped-def]
    """Return (position, attitude, velocity) of the body as in `NavigationOutput`, without their covariances."""
    b, s = belief, settings
    r = s.imu_position
    arm = rotated(b.attitude, r)
    rate = (b.rate[0] - b.gyro_bias[0], b.rate[1] - b.gyro_bias[1], b.rate[2] - b.gyro_bias[2])
    omega = rotated(s.imu_rotation, rate)
    at_imu, lever = rotated_back(b.attitude, b.velocity), cross(omega, r)
    position = (b.position[0] - arm[0], b.position[1] - arm[1], b.position[2] - arm[2])
    velocity = (at_imu[0] - lever[0], at_imu[1] - lever[1], at_imu[2] - lever[2], omega[0], omega[1], omega[2])
    return position, b.attitude, velocity


@equation
def navigation_output(belief, settings):  # type: ignore[no-untyped-def]
    """Return the `NavigationOutput` of a belief."""
    b, s = belief, settings
    r = s.imu_position
    arm = rotated(b.attitude, r)
    position, _, velocity = navigation_motion(belief, settings)
    pose, motion, noise = np.zeros((6, ERRORS)), np.zeros((6, ERRORS)), np.zeros((6, 3))
    in_earth, of_imu = axes(b.attitude), axes(s.imu_rotation)
    unit = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for i in range(3):
        pose[i, i], pose[3 + i, 6 + i] = 1.0, 1.0
        swung, tilt, turned = cross(unit[i], arm), cross(in_earth[i], b.velocity), cross(r, of_imu[i])
        for j in range(3):
            pose[i, 6 + j] = swung[j]
            motion[i, 3 + j], motion[i, 6 + j] = in_earth[i][j], tilt[j]
            motion[j, 9 + i] = -turned[j]
            motion[3 + j, 9 + i] = -of_imu[i][j]
            noise[j, i], noise[3 + j, i] = -turned[j], -of_imu[i][j]
    pose_covariance = pose @ b.P @ pose.T
    velocity_covariance = motion @ b.P @ motion.T + s.gyro_noise**2 * (noise @ noise.T)
    return NavigationOutput(position, b.attitude, velocity, pose_covariance, velocity_covariance)


@compiled
def compiled_begin(heard, settings):  # type: ignore[no-untyped-def]
    """Return the belief before the first step, as `begun` does."""
    return begun(heard, settings, 0)


@compiled
def compiled_first(heard, settings):  # type: ignore[no-untyped-def]
    """Return (NavigationBelief, NavigationInnovation) at the first instant, as `navigation_first` does."""
    return navigation_first(heard, settings)


@compiled
def compiled_navigation(belief, heard, dt, settings):  # type: ignore[no-untyped-def]
    """Return (NavigationBelief, NavigationInnovation), as `navigation_step` does."""
    return navigation_step(belief, heard, dt, settings)


@compiled
def compiled_output(belief, settings):  # type: ignore[no-untyped-def]
    """Return the `NavigationOutput` of a belief."""
    return navigation_output(belief, settings)


@compiled
def run_navigation(heard, dt, belief, settings, values, deviations, nis, status):  # type: ignore[no-untyped-def]
    """Step through K readings (K, 14), fill what `NavigationHistory` holds and return the last belief."""
    for k in range(heard.shape[0]):
        a = heard[k]
        now = Heard(a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8], a[9], a[10], a[11], a[12], a[13])
        belief, innovation = navigation_step(belief, now, dt[k], settings)
        out = navigation_output(belief, settings)
        for j in range(3):
            values[k, j] = out.position[j]
            deviations[k, j] = np.sqrt(out.pose_covariance[j, j])
            deviations[k, 3 + j] = np.sqrt(out.pose_covariance[3 + j, 3 + j])
        for j in range(4):
            values[k, 3 + j] = out.attitude[j]
        for j in range(6):
            values[k, 7 + j] = out.velocity[j]
            deviations[k, 6 + j] = np.sqrt(out.velocity_covariance[j, j])
        nis[k, 0], nis[k, 1], nis[k, 2] = innovation.nis_attitude, innovation.nis_velocity, innovation.nis_depth
        status[k] = belief.status
    return belief


class NavigationHistory(NamedTuple):
    """A whole run of K instants.

    Attributes:
        position (K, 3) [m], attitude (K, 4), velocity (K, 6) [m/s, rad/s]: as in `NavigationOutput`.
        deviations: of position, of turns about the earth's axes [rad], of velocity, shape (K, 12).
        nis: of attitude, velocity and depth, shape (K, 3), NaN where not used.
        status: shape (K,).
        last: the belief after them.
    """

    position: Array
    attitude: Array
    velocity: Array
    deviations: Array
    nis: Array
    status: NDArray[np.int64]
    last: NavigationBelief


def navigate(heard: Array, dt: Array, settings: NavigationSettings) -> NavigationHistory:
    """Run the filter over K instants from its beginning at the first.

    Args:
        heard: what the sensors told, columns as in `Heard`, shape (K, 14); NaN: nothing.
        dt: times since the instant before, shape (K,) [s]; the first does not count.
        settings: `checked_navigation` ones.
    """
    heard = np.ascontiguousarray(heard, dtype=np.float64)
    if heard.ndim != 2 or heard.shape[1] != len(Heard._fields) or not len(heard) or np.shape(dt) != heard.shape[:1]:
        raise ValueError(f"navigate: expected readings of shape (K, 14) and K times; got {heard.shape}, {np.shape(dt)}")
    belief = compiled_begin(Heard(*heard[0].tolist()), settings)
    first = heard.copy()
    first[0, :4], first[0, 13] = np.nan, np.nan  # the beginning has them already
    steps = np.concatenate(([0.0], np.asarray(dt, dtype=np.float64)[1:]))
    values, deviations = np.empty((len(heard), 13)), np.empty((len(heard), 12))
    nis, status = np.empty((len(heard), 3)), np.empty(len(heard), dtype=np.int64)
    last = run_navigation(first, steps, belief, settings, values, deviations, nis, status)
    return NavigationHistory(values[:, :3], values[:, 3:7], values[:, 7:], deviations, nis, status, last)
