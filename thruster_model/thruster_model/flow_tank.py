"""The compiled plant of one thruster in a flow tank: (4.3) to (4.5) with the ramp limit, integrated by RK4.

The throttle is held between commands (zero-order hold); the acting throttle moves towards the command at u_dot_max.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.compilation import compiled, inlined
from thruster_model.effects.stages import NO_EFFECTS
from thruster_model.equations.dead_zone import ramp_limited
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.pipeline import heat_after, memory_length, pipeline, step_limit

__all__ = ["AT_REST", "PlantState", "Trajectory", "plant_step", "run_plant", "simulate"]


class PlantState(NamedTuple):
    """Rotor speed n [rad/s], axial flow v, ambient flow U [m/s], acting throttle u [V], heat of the motor (0 to 1)."""

    n: float
    v: float
    ambient: float
    u: float
    heat: float = 0.0


AT_REST = PlantState(0.0, 0.0, 0.0, 0.0)
NO_GATES = np.empty(0)
NOMINAL_SUPPLY = np.empty(0)
RAMP_STEP = 2.5e-3


class Trajectory(NamedTuple):
    """A simulated run at N + 1 instants, `dt` apart, the first at time 0: arrays of shape (N + 1,), SI units."""

    n: NDArray[np.float64]
    v: NDArray[np.float64]
    ambient: NDArray[np.float64]
    u: NDArray[np.float64]
    thrust: NDArray[np.float64]
    torque: NDArray[np.float64]


@inlined
def plant_step(state, u_commanded, dt, past, gate, supply, p, e):  # type: ignore[no-untyped-def]
    """Return the state after `dt` [s] under the commanded throttle [V], held over the step.

    Where the throttle reaches the command within the step, the step is split there: smeared over the whole step, a
    change of the command would come half a step late. On its way the throttle passes the edges of the dead zone, whose
    kinks want steps of `RAMP_STEP`. `past`, `gate`: see `effects.effect.STAGES`; `supply`: see `pipeline`.
    """
    ramp = min(np.abs(u_commanded - state.u) / p.u_dot_max, dt)
    if ramp > 0.0:
        first, last = state.u, ramp_limited(state.u, u_commanded, p.u_dot_max, dt)
        pieces = int(ramp / RAMP_STEP - 1e-9) + 1
        for k in range(pieces):
            u = last if k == pieces - 1 else first + (last - first) * (k + 1) / pieces
            state = _rk4(state, u, ramp / pieces, past, gate, supply, p, e)
    if ramp < dt:
        state = _rk4(state, state.u, dt - ramp, past, gate, supply, p, e)
    return state


@inlined
def _rates(n, v, ambient, u, heat, past, gate, supply, p, e):  # type: ignore[no-untyped-def]
    return pipeline(n, v, ambient, u, heat, past, gate, supply, p, e)[:3]


@inlined
def _rk4(state, u_end, dt, past, gate, supply, p, e):  # type: ignore[no-untyped-def]
    """Return the state after one RK4 step of `dt` [s], the acting throttle going straight to `u_end` [V]."""
    u_middle = 0.5 * (state.u + u_end)
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
def run_plant(state, u_commanded, dt, substeps, p, e, gates, supplies, out):  # type: ignore[no-untyped-def]
    """Integrate over all commands (N,), `dt` [s] apart, `substeps` RK4 steps each; fill `out` (6, N + 1).

    `e`: `EffectValues` or `NO_EFFECTS`; `gates`, `supplies`: one value per period, or none.
    """
    step = dt / substeps
    back = int(memory_length(0.0, e) / step + 0.5)
    history = np.zeros(back + 1)
    count = 0
    for k in range(u_commanded.size + 1):
        gate = gates[min(k, gates.size - 1)] if gates.size > 0 else 1.0
        supply = supplies[min(k, supplies.size - 1)] if supplies.size > 0 else 1.0
        past = history[count % (back + 1)] if count >= back else 0.0
        now = pipeline(state.n, state.v, state.ambient, state.u, state.heat, past, gate, supply, p, e)
        out[0, k], out[1, k], out[2, k], out[4, k], out[5, k] = now[3], now[4], now[5], now[6], now[7]
        out[3, k] = state.u
        if k < u_commanded.size:
            for _ in range(substeps):
                past = history[count % (back + 1)] if count >= back else 0.0
                history[(count + back) % (back + 1)] = state.ambient
                state = plant_step(state, u_commanded[k], step, past, gate, supply, p, e)
                count += 1
    return state


def simulate(
    coefficients: ThrusterCoefficients,
    u_commanded: ArrayLike,
    dt: float,
    *,
    initial: PlantState = AT_REST,
    largest_step: float = 1e-3,
    effects: Any = NO_EFFECTS,
    gates: ArrayLike = NO_GATES,
    supply: ArrayLike = NOMINAL_SUPPLY,
) -> Trajectory:
    """Simulate the thruster under a commanded throttle.

    Args:
        coefficients: of the common form, `ParameterSet.coefficients`.
        u_commanded: throttle commands [V], shape (N,), each held for `dt`.
        dt: period of the commands [s].
        initial: state at the first command.
        largest_step: upper bound of the integration step [s]; effects that act more abruptly take shorter ones.
        effects: `EffectValues` of unmodelled effects that act in the plant, or none.
        gates: 0 in periods in which the propeller may draw air, else 1, shape (N,); empty: never.
        supply: voltage of the supply over the nominal one in each period, shape (N,); empty: 1.

    Returns:
        Trajectory at the N + 1 instants 0, dt, ..., N dt.
    """
    commands = np.ascontiguousarray(u_commanded, dtype=np.float64)
    if commands.ndim != 1 or not np.all(np.isfinite(commands)):
        raise ValueError(f"u_commanded: expected finite values of shape (N,), got shape {commands.shape}")
    if not (dt > 0 and largest_step > 0):
        raise ValueError(f"dt and largest_step: expected positive times, got {dt} s and {largest_step} s")
    substeps = max(1, int(np.ceil(dt / float(step_limit(largest_step, effects)) - 1e-9)))
    out = np.empty((6, commands.size + 1))
    start = PlantState(*map(float, initial))
    opened = np.ascontiguousarray(gates, dtype=np.float64)
    volts = np.ascontiguousarray(supply, dtype=np.float64)
    if volts.size not in (0, commands.size) or not np.all(np.isfinite(volts) & (volts >= 0.0)):
        raise ValueError(f"supply: expected finite values from 0 of the commands' shape, got shape {volts.shape}")
    run_plant(start, commands, float(dt), substeps, coefficients, effects, opened, volts, out)
    return Trajectory(*out)
