"""The vehicle's kernels: one step, one period, a whole run. What a run does is what its periods do, bit for bit.

Each throttle is held between commands; the acting throttle moves towards the command at u_dot_max. Where one of the
throttles reaches its command within a step, the step is split there, and while one moves, steps are no longer than
`RAMP_STEP`: see `stepper.plant_step`. What effects make of a command on its way acts once a step; where a delay ends
within a step, the step is split there too. Arguments: `rates`.
"""

import numpy as np

from rov_sim.vehicle.rates import (
    inflow_at,
    interact,
    load_share,
    rates,
    relative_velocity,
)
from rov_sim.vehicle.tables import (
    AFTER,
    AMBIENT,
    AT,
    AXIAL,
    BEFORE,
    BODY,
    END,
    FIRST,
    GAINED,
    LATE,
    LEFT,
    MEMORY,
    MIDDLE,
    REACHED,
    SLOPE,
    SPEED,
    STATE,
    TORQUE,
    TURNING,
    WIRING,
)
from thruster_model.acting_throttle import followed
from thruster_model.compilation import borrowed, compiled, inlined
from thruster_model.effects.chains import command_split
from thruster_model.equations.dead_zone import ramp_limited
from thruster_model.pipeline import heat_after, lag_time, ramp_limit, step_limit
from thruster_model.stepper import RAMP_STEP
from thruster_model.thruster_rows import thruster

__all__ = ["COARSE", "FINE", "advance", "advance_period", "known_rates", "measured", "record_width", "run_vehicle"]

FINE, COARSE = 4, 2
"""Stages of a step: the four of Runge and Kutta, the two of the midpoint rule."""
_SAME_INSTANT = 1e-12  # s
_LAG_STEP = 12.5e-3
"""[s] Of throttles that lag, where pieces end at the last one that is reached: they bend at the edges of dead zones
alone. What a gyro is expected to read in a minute with a lag of 0.15 s changes by 2e-6 rad/s."""


@inlined
def _runge_kutta(sheet, dt, gate, wrench, body, layout, p, e, known, stages):  # type: ignore[no-untyped-def]
    """Advance the state by one step of `dt` [s], the acting throttles going by row MIDDLE to row END [V].

    known: whether row SLOPE holds the rates of the state. stages: `FINE` or `COARSE`.
    """
    N = layout.shape[0]
    states, u = BODY + 2 * N, BODY + 2 * N
    for i in range(BODY + 4 * N):
        sheet[AT, i], sheet[GAINED, i] = sheet[STATE, i], 0.0
    for stage in range(stages):  # one place for the rates: a kernel with four copies of them compiles for minutes
        if stage > 0 or not known:
            rates(sheet, AT, gate, wrench, body, layout, p, e)
        weight = 2.0 if stage == 1 or stage == 2 else 1.0
        if stages == COARSE:
            weight = 6.0 * stage
        ahead = dt if stage == 2 else 0.5 * dt
        for i in range(states):
            sheet[GAINED, i] += weight * sheet[SLOPE, i]
            sheet[AT, i] = sheet[STATE, i] + ahead * sheet[SLOPE, i]
        for i in range(u, u + N):
            sheet[AT, i] = sheet[END, i] if stage == 2 else sheet[MIDDLE, i]
    sixth = dt / 6.0
    for i in range(states):
        sheet[STATE, i] += sixth * sheet[GAINED, i]
    w, x, y, z = sheet[STATE, 3], sheet[STATE, 4], sheet[STATE, 5], sheet[STATE, 6]
    scale = 1.0 / np.sqrt(w * w + x * x + y * y + z * z)
    for i in range(3, 7):
        sheet[STATE, i] *= scale
    for i in range(N):
        heat = u + N + i
        sheet[STATE, heat] = heat_after(sheet[STATE, heat], sheet[MIDDLE, u + i], dt, thruster(p, i), thruster(e, i))
        sheet[STATE, u + i] = sheet[END, u + i]


@inlined
def _stir(sheet, body, layout, p):  # type: ignore[no-untyped-def]
    """Let idle thrusters in a stream leave v = 0, an equilibrium of (4.4) that no water keeps; return if one does."""
    N = layout.shape[0]
    stirred = False
    for i in range(N):
        if sheet[STATE, BODY + i] == 0.0 and sheet[STATE, BODY + N + i] == 0.0:
            nu_1, nu_2, _ = relative_velocity(sheet, STATE, body)
            U, own = inflow_at(i, nu_1, nu_2, layout), thruster(p, i)
            if own.k_Uv * own.k_w * abs(U) > own.k_v:
                sheet[STATE, BODY + N + i] = body.stir * np.sign(U)
                stirred = True
    return stirred


@inlined
def _step(sheet, dt, gate, wrench, body, layout, p, e, apart, known, stages):  # type: ignore[no-untyped-def]
    """Advance the state by `dt` [s] towards the throttles of row REACHED, in pieces where they are reached.

    apart: whether a piece ends where any of them is reached; else where the last one is. known, stages: see
    `_runge_kutta`.
    """
    N = layout.shape[0]
    first, last = BODY + 2 * N, BODY + 3 * N
    if _stir(sheet, body, layout, p):
        known = False
    left = dt
    while left > 0.0:
        piece, longest, moving, finest = left, 0.0, False, _LAG_STEP
        for i in range(first, last):
            if sheet[REACHED, i] != sheet[STATE, i]:
                moving = True
                own = thruster(e, i - first)
                ramp = abs(sheet[REACHED, i] - sheet[STATE, i]) / ramp_limit(thruster(p, i - first).u_dot_max, own)
                lag = lag_time(0.0, sheet[STATE, i], sheet[REACHED, i], own)
                if apart or ramp > lag:  # at the limit of its rate
                    finest = RAMP_STEP
                if lag > 0.0:
                    longest = left
                elif apart and ramp < piece - _SAME_INSTANT:
                    piece = ramp
                longest = max(longest, ramp)
        if moving and not apart and longest < left - _SAME_INSTANT:
            piece = longest
        count = int(piece / finest - 1e-9) + 1 if moving else 1
        count = max(count, int(piece / _integrable(sheet, piece, N, e) - 1e-9) + 1)
        for i in range(first, last):
            sheet[FIRST, i] = sheet[STATE, i]
            sheet[MIDDLE, i] = sheet[STATE, i]
            sheet[END, i] = sheet[STATE, i]
        for k in range(count):
            if moving:
                _throttles_after(sheet, MIDDLE, (k + 0.5) / count * piece, p, e, first, last)
                _throttles_after(sheet, END, (k + 1) / count * piece, p, e, first, last)
            _runge_kutta(sheet, piece / count, gate, wrench, body, layout, p, e, known, stages)
            known = False
        left = left - piece if piece < left - _SAME_INSTANT else 0.0


@inlined
def _integrable(sheet, dt, N, e):  # type: ignore[no-untyped-def]
    """Return the longest step, at most `dt` [s], that integrates from the state, with the rates of row SLOPE."""
    for i in range(N):
        n, v = BODY + i, BODY + N + i
        dt = step_limit(dt, sheet[STATE, n], sheet[SLOPE, n], sheet[STATE, v], sheet[SLOPE, v], thruster(e, i))
    return dt


@inlined
def _throttles_after(sheet, row, time, p, e, first, last):  # type: ignore[no-untyped-def]
    """Fill a row with the acting throttles [V] `time` [s] after those of row FIRST."""
    for i in range(first, last):
        own = thruster(e, i - first)
        rate = ramp_limit(thruster(p, i - first).u_dot_max, own)
        lag = lag_time(0.0, sheet[FIRST, i], sheet[REACHED, i], own)
        if lag > 0.0:
            sheet[row, i] = followed(sheet[FIRST, i], sheet[REACHED, i], 0.0, time, rate, lag)
        elif abs(sheet[REACHED, i] - sheet[FIRST, i]) <= rate * (time + _SAME_INSTANT):
            sheet[row, i] = sheet[REACHED, i]
        else:
            sheet[row, i] = ramp_limited(sheet[FIRST, i], sheet[REACHED, i], rate, time)


@inlined
def advance(  # type: ignore[no-untyped-def]
    sheet, commands, steps, step, gate, wrench, body, layout, p, e, apart=True, known=False, stages=FINE
):  # fmt: skip
    """Advance the state in place by `steps` steps of `step` [s] under throttle commands (N,) [V], held.

    Args:
        apart: whether steps are split at each throttle that is reached; else at the last one, which for six thrusters
            is half the work: the others' kinks, within pieces of `RAMP_STEP`, cost 1e-4 V s of a command.
        known, stages: see `_runge_kutta`.
    """
    N = layout.shape[0]
    first = BODY + 2 * N
    remembers = sheet.shape[0] > MEMORY
    for _ in range(steps):
        for i in range(N):
            u = commands[int(layout[i, WIRING])]
            before, late, after = u, 0.0, u
            if remembers:
                before, late, after = command_split(sheet[MEMORY + i], u, step, thruster(e, i))
            sheet[BEFORE, first + i], sheet[AFTER, first + i] = layout[i, TURNING] * before, layout[i, TURNING] * after
            sheet[LATE, first + i] = late if before != after else 0.0
        gone = 0.0
        while gone < step:
            until = step
            for i in range(first, first + N):
                early = sheet[LATE, i] > gone + _SAME_INSTANT
                sheet[REACHED, i] = sheet[BEFORE, i] if early else sheet[AFTER, i]
                if early:
                    until = min(until, sheet[LATE, i])
            _step(sheet, until - gone, gate, wrench, body, layout, p, e, apart, known, stages)
            gone, known = until, False


@compiled
def advance_period(sheet, commands, steps, step, gate, wrench, body, layout, p, e):  # type: ignore[no-untyped-def]
    """`advance` as a kernel of its own."""
    sheet, commands, gate, wrench, body, layout, p, e = borrowed((sheet, commands, gate, wrench, body, layout, p, e))
    advance(sheet, commands, steps, step, gate, wrench, body, layout, p, e)


def record_width(thrusters: int) -> int:
    """Return how many numbers `measured` tells of a vehicle with so many thrusters."""
    return BODY + 8 + 6 * thrusters


@inlined
def known_rates(sheet, gate, wrench, body, layout, p, e):  # type: ignore[no-untyped-def]
    """Fill row SLOPE with the rates of the state, see `rates`."""
    for i in range(BODY + 4 * layout.shape[0]):
        sheet[AT, i] = sheet[STATE, i]
    return rates(sheet, AT, gate, wrench, body, layout, p, e)


@compiled
def measured(sheet, gate, wrench, body, layout, p, e, out):  # type: ignore[no-untyped-def]
    """Fill out with position, attitude, velocity (13), acceleration (6), supply, current, then (N,) each of rotor
    speed, axial flow, ambient flow, acting throttle, thrust, torque.

    The thrust is what arrives at the vehicle; supply and current are relative.
    """
    sheet, gate, wrench, body, layout, p, e = borrowed((sheet, gate, wrench, body, layout, p, e))
    N = layout.shape[0]
    load, supply = known_rates(sheet, gate, wrench, body, layout, p, e)
    out[:BODY] = sheet[STATE, :BODY]
    out[BODY : BODY + 6] = sheet[SLOPE, 7:BODY]
    out[BODY + 6], out[BODY + 7] = supply, load if body.sags else load_share(sheet, AT, p, e)
    interact(sheet, layout)
    at = BODY + 8
    for i in range(N):
        out[at + i], out[at + N + i], out[at + 2 * N + i] = sheet[SPEED, i], sheet[AXIAL, i], sheet[AMBIENT, i]
        out[at + 3 * N + i], out[at + 4 * N + i] = sheet[STATE, BODY + 2 * N + i], sheet[LEFT, i]
        out[at + 5 * N + i] = sheet[TORQUE, i]


@compiled
def run_vehicle(sheet, commands, steps, step, gates, wrenches, body, layout, p, e, out):  # type: ignore[no-untyped-def]
    """Advance the state through periods of held commands (K, N); fill out (K + 1, ...) with `measured` at all instants.

    gates (K, N) and wrenches (K, 6): of each period. Returns the number of periods done: fewer than K where the state
    is no longer finite.
    """
    K = commands.shape[0]
    for k in range(K):
        measured(sheet, gates[k], wrenches[k], body, layout, p, e, out[k])
        advance_period(sheet, commands[k], steps, step, gates[k], wrenches[k], body, layout, p, e)
        if not np.all(np.isfinite(sheet[STATE])):
            return k
    if K > 0:
        measured(sheet, gates[K - 1], wrenches[K - 1], body, layout, p, e, out[K])
    return K
