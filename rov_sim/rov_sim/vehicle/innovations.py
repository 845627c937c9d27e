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

from rov_sim.vehicle.kernel import advance_together, measured, record_width
from rov_sim.vehicle.sensors.measuring import battery_measured, depth_measured, imu_measured, velocity_measured
from rov_sim.vehicle.tables import BODY, STATE, TURNING, Body
from thruster_model.compilation import borrowed, compiled, inlined
from thruster_model.equations.attitude import conjugate, normalised, quaternion_product
from thruster_model.equations.rotation_vector import rotation, rotation_vector

__all__ = ["CHANNELS", "CORRECTED", "States", "innovations", "record_width", "states_of", "states_width"]

CHANNELS, CORRECTED = 13, 16
"""Channels that correct the body's state, and what they correct."""
_IMU, _LOG, _BOTH = 0, 10, 13
"""Columns of what IMU and velocity log would tell, and how many."""
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


def states_of(rows: NDArray[np.float64]) -> States:
    """Return what rows of `states` hold, (..., 19 + 3 N)."""
    N = (rows.shape[-1] - 19) // 3
    return States(*np.split(rows, [3, 7, 13, 19, 19 + N, 19 + 2 * N], axis=-1))


@compiled
def innovations(  # type: ignore[no-untyped-def]
    sheet, commands, steps, step, extra, keep, body, layout, p, e, c, tach, attitude, told, speeds, battery, lateness,
    gains, speed_gains, charge, out, out_n, out_b, states,
):  # fmt: skip
    """Run the filter over K periods; return how many were done, fewer than K where the state is no longer finite.

    Args:
        sheet: with the state at the first instant; steps, step: of a period, as in `kernel.advance`.
        commands: (K, N) throttles [V]; extra: (K, 6) wrenches beside w [N, N m]; keep: share of w left after a period.
        body, layout, p, e: `Tables`; c: `SensorCoefficients`.
        tach: (N, 2), of each tachometer: scale, time constant of its lag in periods.
        attitude: (K, 4); told: (K, 13), first three unused; speeds: (K, N); battery: (K, 2) [V, A]; NaN: not measured.
        lateness: (K,), by which the velocity in row k was measured before instant k, in periods. Of an IMU that is late
            by c.imu_late a row is taken as many whole periods later, and expected as it was the rest of one before.
        gains: (K, 16, 13); speed_gains: (K, N).
        charge: (4,), of the battery: its voltage at rest over the nominal one; the time in which it is followed, in
            periods, infinite: never; readings of it so far, whose mean it is until then; periods since the last one.
            Left as it is at the end, for what follows.
        out: (K, 13), out_n: (K, N), out_b: (K, 2): innovations, NaN where nothing was measured.
        states: (K, 19 + 3 N), as `States`.
    """
    sheet, body, layout, p, e, tach = borrowed((sheet, body, layout, p, e, tach))
    commands, extra, attitude, told, speeds, battery = borrowed((commands, extra, attitude, told, speeds, battery))
    gains, speed_gains, out, out_n, out_b, states = borrowed((gains, speed_gains, out, out_n, out_b, states))
    K, N = commands.shape
    row = np.empty(record_width_of(N))
    gate, w, wrench = np.ones(N), np.zeros(6), np.zeros(6)
    lagging = np.zeros(N)
    for i in range(N):
        lagging[i] = sheet[STATE, BODY + i]
    history, then = np.zeros((K, _BOTH)), np.zeros(_BOTH)
    error, dx = np.zeros(CHANNELS), np.zeros(CORRECTED)
    old = c.imu_late / (steps * step)
    whole = int(old)
    for k in range(K):
        for j in range(6):
            wrench[j] = w[j] + extra[k, j]
        fed = _charged(body, charge[0])
        measured(sheet, gate, wrench, fed, layout, p, e, row)
        imu = imu_measured(row[3:7], row[7:13], row[13:19], row[20], c, _NO_IMU)
        log = velocity_measured(row[7:13], c, _NO_VELOCITY)
        for j in range(_LOG):
            history[k, j] = imu[j]
        history[k, _LOG], history[k, _LOG + 1], history[k, _LOG + 2] = log.x, log.y, log.z
        of_now = min(k + whole, K - 1)
        _then(history, k, old - whole, _IMU, _LOG, then)
        _then(history, k, lateness[k] + c.velocity_late / (steps * step), _LOG, _BOTH, then)
        predicted = normalised((then[0], then[1], then[2], then[3]))
        seen = (attitude[of_now, 0], attitude[of_now, 1], attitude[of_now, 2], attitude[of_now, 3])
        turn = rotation_vector(quaternion_product(conjugate(predicted), seen))
        out[k, 0], out[k, 1], out[k, 2] = turn
        for j in range(6):
            out[k, 3 + j] = told[of_now, 3 + j] - then[4 + j]
        out[k, 9] = told[k, 9] - depth_measured(row[0:3], row[3:7], c, (0.0,))
        for j in range(3):
            out[k, 10 + j] = told[k, 10 + j] - then[_LOG + j]
        power = battery_measured(row[19], row[20], c, (0.0, 0.0))
        out_b[k, 0], out_b[k, 1] = battery[k, 0] - power.voltage, battery[k, 1] - power.current
        charge[3] += 1.0
        if np.isfinite(out_b[k, 0]) and charge[1] < np.inf:
            charge[2] += 1.0
            charge[0] += max(1.0 / charge[2], 1.0 - np.exp(-charge[3] / charge[1])) * out_b[k, 0] / c.nominal_voltage
            charge[3], fed = 0.0, _charged(body, charge[0])
        for j in range(CHANNELS):
            error[j] = out[k, j] if np.isfinite(out[k, j]) else 0.0
        for i in range(CORRECTED):
            moved = 0.0
            for j in range(CHANNELS):
                moved += gains[k, i, j] * error[j]
            dx[i] = moved
        q = quaternion_product(
            (sheet[STATE, 3], sheet[STATE, 4], sheet[STATE, 5], sheet[STATE, 6]), rotation((dx[0], dx[1], dx[2]))
        )
        sheet[STATE, 3], sheet[STATE, 4], sheet[STATE, 5], sheet[STATE, 6] = q
        for j in range(6):
            sheet[STATE, 7 + j] += dx[3 + j]
            w[j] += dx[9 + j]
            wrench[j] = w[j] + extra[k, j]
        sheet[STATE, 2] += dx[15]
        if old > 0.0:  # what comes next tells of this instant too, and of what is believed of it now
            imu = imu_measured(sheet[STATE, 3:7], sheet[STATE, 7:13], row[13:19], row[20], c, _NO_IMU)
            for j in range(_LOG):
                history[k, j] = imu[j]
        for i in range(N):
            n = row[BODY + 8 + i]
            follow = np.exp(-1.0 / tach[i, 1]) if tach[i, 1] > 0.0 else 0.0
            lagging[i] = follow * lagging[i] + (1.0 - follow) * n
            expected = tach[i, 0] * lagging[i]
            out_n[k, i] = speeds[k, i] - (expected if c.signed else abs(expected))
            if np.isfinite(out_n[k, i]) and layout[i, TURNING] != 0.0:
                side = 1.0 if c.signed or expected >= 0.0 else -1.0
                sheet[STATE, BODY + i] += speed_gains[k, i] * side * out_n[k, i]
            states[k, 19 + i] = sheet[STATE, BODY + i]
            states[k, 19 + N + i] = row[BODY + 8 + 4 * N + i]
            states[k, 19 + 2 * N + i] = sheet[STATE, BODY + N + i]
        for j in range(13):
            states[k, j] = sheet[STATE, j]
        for j in range(6):
            states[k, 13 + j] = w[j]
        advance_together(sheet, commands[k], steps, step, gate, wrench, fed, layout, p, e)
        for j in range(6):
            w[j] *= keep
        for j in range(BODY + 4 * N):
            if not np.isfinite(sheet[STATE, j]):
                return k
    return K


@inlined
def _charged(body, charge):  # type: ignore[no-untyped-def]
    """Return the numbers of a body whose battery has so much of its nominal voltage at rest."""
    return Body(
        body.M, body.M_inverse, body.D_L, body.D_Q, body.weight, body.buoyancy, body.r_G, body.r_B, body.current,
        body.tether, body.supply * charge, body.sag, body.stir, body.interacts, body.reacts, body.tethered, body.sags,
    )  # fmt: skip


@inlined
def _then(history, k, ago, begin, end, out):  # type: ignore[no-untyped-def]
    """Fill columns of `out` with what they were `ago` periods before row k, in a history up to there."""
    at = max(k - ago, 0.0)
    first = min(int(at), k)
    share = at - first
    for j in range(begin, end):
        out[j] = history[first, j]
        if first < k:
            out[j] += share * (history[first + 1, j] - out[j])
        elif k > 0:
            out[j] += share * (history[k, j] - history[k - 1, j])


@compiled
def record_width_of(thrusters):  # type: ignore[no-untyped-def]
    """Return `kernel.record_width` inside a kernel."""
    return BODY + 8 + 6 * thrusters
