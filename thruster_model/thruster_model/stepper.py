"""The one stepper of a thruster: command, plant and sensors with their effects, advanced as far as one likes at a time.

    commands, held or lines ──> command effects ──> plant: (4.3) to (4.5) by RK4 ──> true outputs ──> sensors' effects

A run advanced in pieces is the run advanced at once, bit for bit: all that is remembered is in `PlantState` and in
`Memory`. Nothing grows with the length of a run.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.acting_throttle import followed, reaching
from thruster_model.compilation import borrowed, compiled, inlined
from thruster_model.effects.chains import (
    SENSED,
    Outputs,
    ambient_alters,
    ambient_sample,
    axial_alters,
    axial_sample,
    command_begin,
    command_memory,
    command_split,
    sensor_memory,
    sensor_seed,
    speed_alters,
    speed_sample,
    thrust_alters,
    thrust_sample,
    torque_alters,
    torque_sample,
)
from thruster_model.effects.delay_line import delayed, line_floats
from thruster_model.pipeline import heat_after, lag_time, memory_length, pipeline, ramp_limit, step_limit

__all__ = [
    "AT_REST",
    "NOMINAL_SUPPLY",
    "NO_GATES",
    "ROWS",
    "Memory",
    "PlantState",
    "Sensors",
    "advance",
    "fill",
    "new_memory",
    "new_sensors",
    "plant_step",
    "sense",
    "substeps_of",
]

Array = NDArray[np.float64]


class PlantState(NamedTuple):
    """Rotor speed n [rad/s], axial flow v, ambient flow U [m/s], acting throttle u [V], heat of the motor (0 to 1)."""

    n: float
    v: float
    ambient: float
    u: float
    heat: float = 0.0


class Memory(NamedTuple):
    """What command effects and the water in the tank remember; floats, changed in place.

    lines: the last two commands that reached the plant [V], the later one first, where the command goes on straight
    lines from one to the next; empty where each is held.
    """

    command: Array
    water: Array
    lines: Array


class Sensors(NamedTuple):
    """What each sensor's effects remember; floats, changed in place."""

    speed: Array
    axial: Array
    ambient: Array
    thrust: Array
    torque: Array


AT_REST = PlantState(0.0, 0.0, 0.0, 0.0)
NO_GATES = np.empty(0)
NOMINAL_SUPPLY = np.empty(0)
ROWS = (*SENSED, "throttle")
"""Rows of what `advance` fills in: n [rad/s], v, U [m/s], T [N], Q [N m], acting throttle u [V]."""
RAMP_STEP = 2.5e-3
_INSTANT = 1e-9
"""[s] Shorter than any step that counts."""


def substeps_of(dt: float, largest_step: float, e: Any) -> int:
    """Return how many steps of the integration a period [s] takes, for a largest step [s] and for effects, whatever the
    thruster does in it."""
    limit = float(step_limit(largest_step, 0.0, np.inf, 0.0, np.inf, e))
    return max(1, int(np.ceil(dt / limit - 1e-9)))


def new_memory(dt: float, substeps: int, e: Any, u: float = 0.0, parts: int = 1, *, straight: bool = False) -> Memory:
    """Return the memory at the beginning of a run of periods dt [s], before which the throttle u [V] acted for long.

    `parts`: commands in a period; `straight`: the command goes on a straight line to each, and is there as its part
    ends.
    """
    part = dt / parts
    memory = Memory(
        np.zeros(command_memory(part, e)),
        np.zeros(line_floats(float(memory_length(0.0, e)), dt / substeps)),
        np.full(2, float(u)) if straight else np.empty(0),
    )
    command_begin(memory.command, u, part, e)
    return memory


def new_sensors(dt: float, e: Any, seed: int = 0) -> Sensors:
    """Return the sensors' memory at the beginning; `seed`: of effects that scatter, 0: they do nothing."""
    sensors = Sensors(*(np.zeros(sensor_memory(signal, dt, e)) for signal in SENSED))
    if seed:
        for k, memory in enumerate(sensors):
            sensor_seed(memory, SENSED[k], len(SENSED) * seed + k, dt, e)
    return sensors


@inlined
def plant_step(state, u_commanded, slope, dt, rate, lag, past, gate, supply, p, e):  # type: ignore[no-untyped-def]
    """Return the state after `dt` [s] under a commanded throttle [V] that moves at `slope` [V/s] from there on.

    Where the throttle reaches the command within the step, the step is split there: smeared over the whole step, a
    change of the command would come half a step late. On its way the throttle passes the edges of the dead zone, whose
    kinks want steps of `RAMP_STEP`. `rate` [V/s], `lag` [s]: of the acting throttle; `past`, `gate`: see
    `effects.effect.STAGES`; `supply`: see `pipeline`.
    """
    first = state.u
    reached = min(reaching(u_commanded - first, slope, rate), dt)
    if lag > 0.0 and (reached > 0.0 or slope != 0.0):
        reached = dt
    begun = 0.0
    for until in (reached, dt):
        length = until - begun
        if length > _INSTANT:
            rests = slope == 0.0 and until > reached
            pieces = 1 if rests else int(length / RAMP_STEP - 1e-9) + 1
            for k in range(pieces):
                at = until if k == pieces - 1 else begun + length * (k + 1) / pieces
                middle = followed(first, u_commanded, slope, begun + length * (k + 0.5) / pieces, rate, lag)
                u = followed(first, u_commanded, slope, at, rate, lag)
                state = _rk4(state, middle, u, length / pieces, past, gate, supply, p, e)
            begun = until
    return state


@inlined
def _rates(n, v, ambient, u, heat, past, gate, supply, p, e):  # type: ignore[no-untyped-def]
    return pipeline(n, v, ambient, u, heat, past, gate, supply, p, e)[:3]


@inlined
def _rk4(state, u_middle, u_end, dt, past, gate, supply, p, e):  # type: ignore[no-untyped-def]
    """Return the state after one RK4 step of `dt` [s], the acting throttle going by `u_middle` to `u_end` [V]."""
    n, v, ambient, heat = state.n, state.v, state.ambient, state.heat
    n1, v1, a1 = _rates(n, v, ambient, state.u, heat, past, gate, supply, p, e)
    half = 0.5 * dt
    n2, v2, a2 = _rates(n + half * n1, v + half * v1, ambient + half * a1, u_middle, heat, past, gate, supply, p, e)
    n3, v3, a3 = _rates(n + half * n2, v + half * v2, ambient + half * a2, u_middle, heat, past, gate, supply, p, e)
    n4, v4, a4 = _rates(n + dt * n3, v + dt * v3, ambient + dt * a3, u_end, heat, past, gate, supply, p, e)
    sixth = dt / 6.0
    return PlantState(
        n + sixth * (n1 + 2.0 * (n2 + n3) + n4),
        v + sixth * (v1 + 2.0 * (v2 + v3) + v4),
        ambient + sixth * (a1 + 2.0 * (a2 + a3) + a4),
        u_end,
        heat_after(heat, u_middle, dt, p, e),
    )


@compiled
def advance(state, commands, dt, substeps, p, e, gates, supplies, memory, out, at):  # type: ignore[no-untyped-def]
    """Return the state after the N periods of `commands`; fill the columns `at` to `at` + N of `out`.

    Column `at` + N is what there is at the end. The next piece fills it in again, with its own first gate, and it is
    then that it becomes part of the run.

    Args:
        state: `PlantState`.
        commands: (N, parts) [V]: each is held for an equal part of a period, or reached as it ends, see `Memory`.
        dt: period [s].
        substeps: steps of the integration in each, which are cut where the throttle changes.
        p: coefficients of any class; e: `EffectValues` or `NO_EFFECTS`.
        gates: by period, 0 where the propeller may draw air, else 1; the last one goes on; none: 1.
        supplies: by period, voltage of the supply over the nominal one; the last one goes on; none: 1.
        memory: `Memory`.
        out: (6, M), the rows of `ROWS`.
        at: column.
    """
    commands, p, gates, supplies, memory, out = borrowed((commands, p, gates, supplies, memory, out))
    step = dt / substeps
    rate = ramp_limit(p.u_dot_max, e)
    water, lines = memory.water, memory.lines
    remembered, straight = water.size > 2, lines.size > 0
    past = 0.0
    N, parts = commands.shape
    part = dt / parts
    for k in range(N + 1):
        gate = gates[min(k, gates.size - 1)] if gates.size > 0 else 1.0
        supply = supplies[min(k, supplies.size - 1)] if supplies.size > 0 else 1.0
        if remembered:
            past = water[1 + (int(water[0]) + 1) % (water.size - 1)]
        now = pipeline(state.n, state.v, state.ambient, state.u, state.heat, past, gate, supply, p, e)
        out[0, at + k], out[1, at + k], out[2, at + k] = now[3], now[4], now[5]
        out[3, at + k], out[4, at + k], out[5, at + k] = now[6], now[7], state.u
        if k == N:
            break
        done, room = 0.0, 0.0  # of the period; of the step
        for j in range(parts):
            before, late, after = command_split(memory.command, commands[k, j], part, e)
            cut = j * part + late if before != after or straight else 0.0
            slope, slope_then = 0.0, 0.0  # of the command until the cut, and from there on
            if straight:
                before, slope, slope_then = lines[0], (lines[0] - lines[1]) / part, (after - lines[0]) / part
                lines[0], lines[1], after = after, before, before
            until = dt if j == parts - 1 else (j + 1) * part
            if not straight and parts > 1 and cut <= done and j < parts - 1 and commands[k, j + 1] == commands[k, j]:
                continue  # what is held on is integrated with what follows
            while done < until - _INSTANT:
                if room <= _INSTANT:
                    room = step
                    if remembered:
                        past, _ = delayed(water, state.ambient)
                u, end, rise = before, min(cut, until), slope
                if cut <= done + _INSTANT:
                    u, end, rise = after, until, slope_then
                length = room if done + room < end + _INSTANT else end - done
                lag = lag_time(0.0, state.u, u + rise * (done + length - cut), e)
                state = plant_step(state, u + rise * (done - cut), rise, length, rate, lag, past, gate, supply, p, e)
                done, room = done + length, room - length
    return state


@compiled
def fill(state, commands, dt, substeps, p, e, gates, supplies, memory, out):  # type: ignore[no-untyped-def]
    """Fill `out` from its first column on: `advance` for callers that need no state.

    It returns nothing: to make a named tuple of what a kernel returns runs Python inside it, and an interrupt that
    came while it ran is raised there, which ends the process with a segmentation fault.
    """
    advance(state, commands, dt, substeps, p, e, gates, supplies, memory, out, 0)


@inlined
def _outputs(true, k):  # type: ignore[no-untyped-def]
    return Outputs(true[0, k], true[1, k], true[2, k], true[3, k], true[4, k])


@compiled
def sense(true, first, last, dt, e, sensors, read):  # type: ignore[no-untyped-def]
    """Fill the columns from `first` to before `last` of `read` (5, M) with what sensors read of `true`, every dt [s].

    Each column is to be read once, in their order; `sensors`: `Sensors`.
    """
    true, sensors, read = borrowed((true, sensors, read))
    read[:, first:last] = true[:5, first:last]
    # One after the other: most sensors are plain, and cost nothing.
    if speed_alters(e):
        for k in range(first, last):
            read[0, k] = speed_sample(sensors.speed, true[0, k], _outputs(true, k), dt, e)
    if axial_alters(e):
        for k in range(first, last):
            read[1, k] = axial_sample(sensors.axial, true[1, k], _outputs(true, k), dt, e)
    if ambient_alters(e):
        for k in range(first, last):
            read[2, k] = ambient_sample(sensors.ambient, true[2, k], _outputs(true, k), dt, e)
    if thrust_alters(e):
        for k in range(first, last):
            read[3, k] = thrust_sample(sensors.thrust, true[3, k], _outputs(true, k), dt, e)
    if torque_alters(e):
        for k in range(first, last):
            read[4, k] = torque_sample(sensors.torque, true[4, k], _outputs(true, k), dt, e)
