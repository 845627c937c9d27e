r"""What a vehicle's sensors tell beside what its plant expects: the plant, corrected at each instant by given gains.

State of the filter: the plant's own, and a wrench w [N, N m] on the body that wanders. At instant k

    e = y - h(x),     x <- x (+) G_k e,     then the plant's own step under u_k and w,     w <- keep w

with e of 13 channels: attitude (a turn of the body) 0-2 [rad], gyro 3-5 [rad/s], specific force 6-8 [m/s^2], depth 9
[m], velocity 10-12 [m/s]; x (+) dx with dx of 16 entries: turn 0-2, nu 3-8, w 9-14, depth 15. Rotor speeds have a gain
of their own each; one that has stopped has none. The equations are the plant's and its sensors', so that every effect
of the library acts here too. A battery's charge is followed slowly beside: what is left of the voltage that the plant
expects feeds its thrusters.
Gains do not depend on the state: what another coefficient changes in e is a difference of two runs of this kernel.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.kernel import COARSE, advance, known_rates
from rov_sim.vehicle.rates import load_share
from rov_sim.vehicle.sensors.measuring import battery_measured, depth_measured, imu_measured, velocity_measured
from rov_sim.vehicle.tables import AT, BODY, LEFT, SLOPE, SPEED, STATE, THRUST, TURNING, Body
from thruster_model.compilation import borrowed, compiled, inlined
from thruster_model.equations.attitude import conjugate, normalised, quaternion_product, rotated
from thruster_model.equations.rotation_vector import rotation, rotation_vector

__all__ = [
    "CHANNELS",
    "CORRECTED",
    "LATE",
    "PARTS",
    "States",
    "followed_charge",
    "innovations",
    "past_width",
    "states_of",
    "states_width",
]

CHANNELS, CORRECTED = 13, 16
"""Channels that correct the body's state, and what they correct."""
LATE = ("attitude", "imu", "depth", "velocity", "battery")
"""Sensors whose readings may be older than the instant they are taken at; the tachometers follow."""
PARTS = 4
"""Of a period, at whose edges states are remembered: a rotor that starts bends within a period."""
_KNOWN = BODY + 8
"""Numbers that sensors other than tachometers read: the body's state, its acceleration, relative supply and load."""
_UNKNOWN_CHARGE, _CHANGE = 1e12, 3.0
"""Of what is believed of a battery before it is read, over a reading's: variance of its level, deviation of its change
in the time in which it is followed."""
_NO_IMU = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
_NO_VELOCITY = (0.0, 0.0, 0.0)


class States(NamedTuple):
    """States of the filter after correction: position (3) [m], attitude (4), nu (6), w (6); of N thrusters their rotor
    speeds [rad/s], thrusts [N] and axial flows [m/s]."""

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    nu: NDArray[np.float64]
    wrench: NDArray[np.float64]
    speeds: NDArray[np.float64]
    thrusts: NDArray[np.float64]
    flows: NDArray[np.float64]


def states_width(thrusters: int) -> int:
    """Return the number of columns of `states` in `innovations`."""
    return 19 + 3 * thrusters


def past_width(thrusters: int) -> int:
    """Return how many numbers `innovations` remembers of the period before, of a vehicle with so many thrusters."""
    return PARTS * (_KNOWN + 2 * thrusters)


def states_of(rows: NDArray[np.float64]) -> States:
    """Return what rows of `states` hold, (..., 19 + 3 N)."""
    N = (rows.shape[-1] - 19) // 3
    return States(*np.split(rows, [3, 7, 13, 19, 19 + N, 19 + 2 * N], axis=-1))


def followed_charge(time: float) -> NDArray[np.float64]:
    """Return how a battery is followed whose voltage at rest is the nominal one, as far as is known, (7,).

    These are: its voltage at rest over the nominal one; the time in which it is followed; by how much it changes in a
    period; variances of both and their covariance, of level, level and change, change, over a reading's; periods since
    the last reading.

    Args:
        time: in which what it does is followed, in periods; infinite: never.
    """
    return np.array([1.0, time, 0.0, _UNKNOWN_CHARGE, 0.0, (_CHANGE / time) ** 2, 0.0])


@compiled
def innovations(  # type: ignore[no-untyped-def]
    sheet, commands, steps, step, stages, extra, keep, body, layout, p, e, c, tach, attitude, told, speeds, battery,
    lateness, gains, speed_gains, charge, past, out, out_n, out_b, states,
):  # fmt: skip
    """Run the filter over K periods; return how many were done, fewer than K where the state is no longer finite.

    Args:
        sheet: with the state at the first instant; steps, step: of one of the `PARTS` of a period, and stages of one,
            as in `kernel.advance`.
        commands: (K, PARTS, N) throttles [V], that act in each part of a period.
        extra: (K, 6) wrenches beside w [N, N m]; keep: share of w left after a period.
        body, layout, p, e: `Tables`; c: `SensorCoefficients`, with the turns in which attitude and `told` were read.
        tach: (N, 2), of each tachometer: scale, time constant of its lag in periods.
        attitude: (K, 4); told: (K, 13), first three unused; speeds: (K, N); battery: (K, 2) [V, A]; NaN: not measured.
        lateness: (K, 5 + N), by which readings of the sensors `LATE` and of the tachometers in row k were made before
            instant k, in periods; each is compared with what was expected then, or, where that is after the instant,
            with what it will be.
        gains: (K, 16, 13); speed_gains: (K, N).
        charge: (7,), see `followed_charge`. Left as it is at the end, for what follows.
        past: (`past_width`,), what was believed in the period before the first instant; NaN: nothing. Left as it is in
            the period before what follows.
        out: (K, 13), out_n: (K, N), out_b: (K, 2): innovations, NaN where nothing was measured.
        states: (K, 19 + 3 N), as `States`.
    """
    sheet, body, layout, p, e, tach = borrowed((sheet, body, layout, p, e, tach))
    commands, extra, attitude, told, speeds, battery = borrowed((commands, extra, attitude, told, speeds, battery))
    gains, speed_gains, out, out_n, out_b, states = borrowed((gains, speed_gains, out, out_n, out_b, states))
    lateness, past = borrowed((lateness, past))
    K, N = commands.shape[0], commands.shape[2]
    gate, w, wrench = np.ones(N), np.zeros(6), np.zeros(6)
    lagging, dx = np.zeros(N), np.zeros(CORRECTED)
    for i in range(N):
        lagging[i] = sheet[STATE, BODY + i]
    # at the edges of each part: the body, each rotor's speed and its slope over a part
    n_at, slope_at = _KNOWN, _KNOWN + N
    width = _KNOWN + 2 * N
    history, then = np.zeros((PARTS * (K + 1), width)), np.zeros(_KNOWN)
    history[:PARTS] = past.reshape((PARTS, width))
    part = steps * step
    drawing = c.magnetic_yaw != 0.0
    for k in range(K):
        for j in range(6):
            wrench[j] = w[j] + extra[k, j]
        fed = _charged(body, charge[0])
        now = PARTS * (k + 1)
        read, read_next = np.isfinite(battery[k, 1]), k + 1 == K or np.isfinite(battery[k + 1, 1])
        for piece in range(PARTS):
            load, supply = known_rates(sheet, gate, wrench, fed, layout, p, e)
            if not body.sags and (drawing or read or read_next):
                load = load_share(sheet, AT, p, e)
            _remember(sheet, supply, load, lagging, tach, part, history[now + piece])
            if piece == 0:
                if k == 0 and np.isnan(history[0, 0]):
                    history[:PARTS] = history[PARTS]
                    history[:PARTS, slope_at:] = 0.0
                for i in range(N):
                    states[k, 19 + N + i] = sheet[LEFT if body.interacts else THRUST, i]
                _tell_body(history, now, k, part, c, attitude, told, lateness, then, out)
                _then(history, now, lateness[k, 4], part, 19, _KNOWN, then)
                power = battery_measured(then[19], then[20], c, (0.0, 0.0))
                out_b[k, 0], out_b[k, 1] = battery[k, 0] - power.voltage, battery[k, 1] - power.current
                _follow_charge(charge, out_b[k, 0] / c.nominal_voltage)
                fed = _charged(body, charge[0])
                _correct_body(sheet, out[k], gains[k], w, dx)
                for j in range(6):
                    wrench[j] = w[j] + extra[k, j]
                for i in range(N):
                    reached = sheet[STATE, BODY + i]
                    first, share = _place(now, lateness[k, 5 + i])
                    expected = tach[i, 0] * _between(
                        history[first, n_at + i], history[first + 1, n_at + i], history[first + 1, slope_at + i], share
                    )
                    out_n[k, i] = speeds[k, i] - (expected if c.signed else abs(expected))
                    if np.isfinite(out_n[k, i]) and layout[i, TURNING] != 0.0:
                        side = 1.0 if c.signed or expected >= 0.0 else -1.0
                        sheet[STATE, BODY + i] += speed_gains[k, i] * side * out_n[k, i]
                    if tach[i, 1] == 0.0:
                        history[now, n_at + i] += sheet[STATE, BODY + i] - reached
                # what is told next may tell of this instant too, and of what is believed of it now
                history[now, :BODY] = sheet[STATE, :BODY]
                for i in range(N):
                    states[k, 19 + i] = sheet[STATE, BODY + i]
                    states[k, 19 + 2 * N + i] = sheet[STATE, BODY + N + i]
                for j in range(13):
                    states[k, j] = sheet[STATE, j]
                for j in range(6):
                    states[k, 13 + j] = w[j]
            known = piece > 0 or stages == COARSE  # what a correction changes of the rates is little in a difference
            advance(sheet, commands[k, piece], steps, step, gate, wrench, fed, layout, p, e, False, known, stages)
        for j in range(6):
            w[j] *= keep
        for j in range(BODY + 4 * N):
            if not np.isfinite(sheet[STATE, j]):
                return k
    past[:] = history[PARTS * K :].reshape(past.size)
    return K


@inlined
def _tell_body(history, now, k, part, c, attitude, told, lateness, then, out):  # type: ignore[no-untyped-def]
    """Fill row k of `out`: what inertial sensors, depth and velocity tell beside what was expected of them."""
    old = c.imu_late / (PARTS * part)
    _then(history, now, old + lateness[k, 1], part, 3, _KNOWN, then)
    imu = imu_measured(then[3:7], then[7:13], then[13:19], then[20], c, _NO_IMU)
    rate = rotated(c.imu_read, (imu[4], imu[5], imu[6]))
    force = rotated(c.imu_read, (imu[7], imu[8], imu[9]))
    for j in range(3):
        out[k, 3 + j], out[k, 6 + j] = told[k, 3 + j] - rate[j], told[k, 6 + j] - force[j]
    if lateness[k, 0] != lateness[k, 1]:
        _then(history, now, old + lateness[k, 0], part, 3, _KNOWN, then)
        imu = imu_measured(then[3:7], then[7:13], then[13:19], then[20], c, _NO_IMU)
    predicted = normalised(quaternion_product((imu[0], imu[1], imu[2], imu[3]), conjugate(c.imu_read)))
    turn = rotation_vector(
        quaternion_product(conjugate(predicted), (attitude[k, 0], attitude[k, 1], attitude[k, 2], attitude[k, 3]))
    )
    out[k, 0], out[k, 1], out[k, 2] = turn
    _then(history, now, lateness[k, 2], part, 0, 7, then)
    out[k, 9] = told[k, 9] - depth_measured(then[0:3], then[3:7], c, (0.0,))
    _then(history, now, lateness[k, 3] + c.velocity_late / (PARTS * part), part, 7, 13, then)
    velocity = rotated(c.velocity_read, velocity_measured(then[7:13], c, _NO_VELOCITY))
    for j in range(3):
        out[k, 10 + j] = told[k, 10 + j] - velocity[j]


@inlined
def _follow_charge(charge, missing):  # type: ignore[no-untyped-def]
    """Move a battery's charge, see `followed_charge`, towards one that lacks nothing; missing: share of the voltage.

    A Kalman filter of a level that changes at a rate which wanders: a battery that empties evenly is not followed late,
    as it would be by a mean of its last readings.
    """
    time = charge[1]
    charge[6] += 1.0
    if np.isfinite(missing) and time < np.inf:
        m = charge[6]
        wanders = m / time**4
        charge[3] += m * (2.0 * charge[4] + m * charge[5]) + wanders * m**3 / 3.0
        charge[4] += m * charge[5] + wanders * m**2 / 2.0
        charge[5] += wanders * m
        of_both = charge[3] + 1.0
        charge[0] += charge[3] / of_both * missing
        charge[2] += charge[4] / of_both * missing
        charge[5] -= charge[4] ** 2 / of_both
        charge[4] /= of_both
        charge[3] /= of_both
        charge[6] = 0.0
    charge[0] += charge[2]


@inlined
def _correct_body(sheet, told, gains, w, dx):  # type: ignore[no-untyped-def]
    """Correct the body's state and the wrench w by innovations (13,), those that are NaN aside; dx: to work in."""
    dx[:] = 0.0
    for i in range(CORRECTED):
        for j in range(CHANNELS):
            dx[i] += gains[i, j] * told[j] if np.isfinite(told[j]) else 0.0
    q = quaternion_product(
        (sheet[STATE, 3], sheet[STATE, 4], sheet[STATE, 5], sheet[STATE, 6]), rotation((dx[0], dx[1], dx[2]))
    )
    sheet[STATE, 3], sheet[STATE, 4], sheet[STATE, 5], sheet[STATE, 6] = q
    for j in range(6):
        sheet[STATE, 7 + j] += dx[3 + j]
        w[j] += dx[9 + j]
    sheet[STATE, 2] += dx[15]


@inlined
def _charged(body, charge):  # type: ignore[no-untyped-def]
    """Return the numbers of a body whose battery has so much of its nominal voltage at rest."""
    return Body(
        body.M, body.M_inverse, body.D_L, body.D_Q, body.weight, body.buoyancy, body.r_G, body.r_B, body.current,
        body.tether, body.ram, body.supply * charge, body.sag, body.stir, body.interacts, body.reacts, body.tethered,
        body.sags,
    )  # fmt: skip


@inlined
def _remember(sheet, supply, load, lagging, tach, part, out):  # type: ignore[no-untyped-def]
    """Fill a row of the history with the state; lagging: what tachometers tell, moved on by a part of a period."""
    for j in range(BODY):
        out[j] = sheet[STATE, j]
    for j in range(6):
        out[BODY + j] = sheet[SLOPE, 7 + j]
    out[BODY + 6], out[BODY + 7] = supply, load
    N = tach.shape[0]
    for i in range(N):
        n, lag = sheet[SPEED, i], PARTS * tach[i, 1]
        lagging[i] = n + (np.exp(-1.0 / lag) * (lagging[i] - n) if lag > 0.0 else 0.0)
        out[_KNOWN + i] = lagging[i]
        out[_KNOWN + N + i] = (n - lagging[i]) / lag if lag > 0.0 else part * sheet[SLOPE, BODY + i]


@inlined
def _then(history, now, ago, part, begin, end, out):  # type: ignore[no-untyped-def]
    """Fill some columns of `out` with what was believed `ago` periods before the instant of row `now`, in a history up
    to it.

    Velocities bend where a thruster starts, by more than a gyro's noise within a period.
    """
    first, share = _place(now, ago)
    for j in range(begin, end):
        a, b = history[first, j], history[first + 1, j]
        if 7 <= j < 13:
            out[j] = _between(a, b, part * history[first + 1, j + 6], share)
        else:
            out[j] = a + share * (b - a)


@inlined
def _place(now, ago):  # type: ignore[no-untyped-def]
    """Return the row of a history before what was `ago` periods before that of row `now`, and the share of a part after
    it; beyond `now` the share is above 1."""
    at = max(now - PARTS * ago, 0.0)
    first = min(int(at), now - 1)
    return first, at - first


@inlined
def _between(a, b, slope, share):  # type: ignore[no-untyped-def]
    """Return the value at a share of a part of a period between its ends a and b; slope: at b, over the part.

    That at the first end is no help: where a command comes a rotor's slope jumps. Beyond the last end the value goes on
    with the slope there.
    """
    if share > 1.0:
        return b + (share - 1.0) * slope
    line = b - a
    return a + share * line + share * (1.0 - share) * (line - slope)
