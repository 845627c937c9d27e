"""The compiled plant of one thruster in a flow tank: (4.3) to (4.5) with the ramp limit, integrated by RK4.

The throttle is held between commands (zero-order hold); the acting throttle moves towards the command at u_dot_max.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.compilation import compiled, equation
from thruster_model.equations.classes import derivative, outputs
from thruster_model.equations.dead_zone import ramp_limited
from thruster_model.equations.thruster import ThrusterCoefficients

__all__ = ["AT_REST", "PlantState", "Trajectory", "plant_step", "run_plant", "simulate"]


class PlantState(NamedTuple):
    """Rotor speed n [rad/s], axial flow v [m/s], ambient flow U [m/s], acting throttle u [V]."""

    n: float
    v: float
    ambient: float
    u: float


AT_REST = PlantState(0.0, 0.0, 0.0, 0.0)


class Trajectory(NamedTuple):
    """A simulated run at N + 1 instants, `dt` apart, the first at time 0: arrays of shape (N + 1,), SI units."""

    n: NDArray[np.float64]
    v: NDArray[np.float64]
    ambient: NDArray[np.float64]
    u: NDArray[np.float64]
    thrust: NDArray[np.float64]
    torque: NDArray[np.float64]


@equation
def plant_step(state, u_commanded, dt, p):  # type: ignore[no-untyped-def]
    """Return the state after `dt` [s] under the commanded throttle [V], held over the step.

    Where the throttle reaches the command within the step, the step is split there: smeared over the whole step, a
    change of the command would come half a step late.
    """
    ramp = np.abs(u_commanded - state.u) / p.u_dot_max
    if 0.0 < ramp < dt:
        state = _rk4(state, u_commanded, ramp, p)
        return _rk4(state, u_commanded, dt - ramp, p)
    return _rk4(state, ramp_limited(state.u, u_commanded, p.u_dot_max, dt), dt, p)


@equation
def _rk4(state, u_end, dt, p):  # type: ignore[no-untyped-def]
    """Return the state after one RK4 step of `dt` [s], the acting throttle going straight to `u_end` [V]."""
    u_middle = 0.5 * (state.u + u_end)
    n, v, ambient = state.n, state.v, state.ambient
    n1, v1, a1 = derivative(n, v, ambient, state.u, p)
    half = 0.5 * dt
    n2, v2, a2 = derivative(n + half * n1, v + half * v1, ambient + half * a1, u_middle, p)
    n3, v3, a3 = derivative(n + half * n2, v + half * v2, ambient + half * a2, u_middle, p)
    n4, v4, a4 = derivative(n + dt * n3, v + dt * v3, ambient + dt * a3, u_end, p)
    sixth = dt / 6.0
    return PlantState(
        n + sixth * (n1 + 2.0 * (n2 + n3) + n4),
        v + sixth * (v1 + 2.0 * (v2 + v3) + v4),
        ambient + sixth * (a1 + 2.0 * (a2 + a3) + a4),
        u_end,
    )


@compiled
def run_plant(state, u_commanded, dt, substeps, p, out):  # type: ignore[no-untyped-def]
    """Integrate over all commands (N,), `dt` [s] apart, `substeps` RK4 steps each; fill `out` (6, N + 1)."""
    for k in range(u_commanded.size + 1):
        out[0, k], out[1, k], out[4, k], out[5, k] = outputs(state.n, state.v, state.ambient, state.u, p)
        out[2, k] = state.ambient
        out[3, k] = state.u
        if k < u_commanded.size:
            for _ in range(substeps):
                state = plant_step(state, u_commanded[k], dt / substeps, p)
    return state


def simulate(
    coefficients: ThrusterCoefficients,
    u_commanded: ArrayLike,
    dt: float,
    *,
    initial: PlantState = AT_REST,
    largest_step: float = 1e-3,
) -> Trajectory:
    """Simulate the thruster under a commanded throttle.

    Args:
        coefficients: of the common form, `ParameterSet.coefficients`.
        u_commanded: throttle commands [V], shape (N,), each held for `dt`.
        dt: period of the commands [s].
        initial: state at the first command.
        largest_step: upper bound of the integration step [s].

    Returns:
        Trajectory at the N + 1 instants 0, dt, ..., N dt.
    """
    commands = np.ascontiguousarray(u_commanded, dtype=np.float64)
    if commands.ndim != 1 or not np.all(np.isfinite(commands)):
        raise ValueError(f"u_commanded: expected finite values of shape (N,), got shape {commands.shape}")
    if not (dt > 0 and largest_step > 0):
        raise ValueError(f"dt and largest_step: expected positive times, got {dt} s and {largest_step} s")
    substeps = max(1, int(np.ceil(dt / largest_step - 1e-9)))
    out = np.empty((6, commands.size + 1))
    run_plant(PlantState(*map(float, initial)), commands, float(dt), substeps, coefficients, out)
    return Trajectory(*out)
