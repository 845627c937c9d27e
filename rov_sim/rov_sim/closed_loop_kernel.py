"""The closed loop's kernel: all periods of a run, the plant by the stepper, the sensors as far as time has come.

The controller's order in a period, at its beginning t_k:

proper    y_k is read, the observer predicts over the last period under the last throttle and takes y_k in, the law
          answers with u_k
bench     the law answers with u_k on what the observer predicted for t_k; then y_k is read and the observer goes on
          to t_k+1 with u_k and y_k, as the bench's did

u_k acts `delay` steps after t_k, until then u_k-1. y_k is what the plant does `sample` steps after t_k, which may be
negative.
"""

from typing import Any, NamedTuple

import numpy as np

from rov_sim.rig_sensors import flow_read, speed_read, throttle_acting
from thruster_control.inner_loop import inner_loop_step
from thruster_estimation.belief import Level, Status, level
from thruster_estimation.observers import observer_step
from thruster_model.compilation import compiled, equation
from thruster_model.effects.chains import SENSED as OUTPUTS
from thruster_model.stepper import NOMINAL_SUPPLY, PlantState, advance, sense

__all__ = ["COLUMNS", "OUTPUTS", "Clock", "PlantSide", "Wiring", "run_loop"]

COLUMNS = ("u", "acting", "n_d", "alpha", "n", "v", "U", "y_n", "y_U", "loop_status", "observer_status")
"""Rows of the controller's record, each period. n, v, U: the estimates that u was computed from; acting: u after the
converter."""
_INVALID = int(np.bitwise_or.reduce([int(s) for s in Status if level(int(s) | int(Status.USED_N)) == Level.INVALID]))


class Clock(NamedTuple):
    """Period dt [s]; `steps` of the plant in it; `sample`, `delay`: see the module [steps]."""

    dt: float
    steps: int
    sample: int
    delay: int


class Wiring(NamedTuple):
    """How the controller is built, 0 or 1 each.

    bench: the bench's order; measured_ambient: the law takes the measured ambient flow, as its observer has none;
    load_cell: the law reads the load cell; quantised: converters round.
    """

    bench: int
    measured_ambient: int
    load_cell: int
    quantised: int


class PlantSide(NamedTuple):
    """What the stepper needs: coefficients, effects, `stepper.Memory`, effects of sensors and `stepper.Sensors`."""

    p: Any
    e: Any
    substeps: int
    memory: Any
    e_sensors: Any
    sensors: Any


@equation
def _answer(memory, belief, T_d, y_U, T, clock, wiring, law, p):  # type: ignore[no-untyped-def]
    """Return (memory, output) of the law for the belief."""
    valid = wiring.bench == 1 or (belief.status != 0 and belief.status & _INVALID == 0)
    U = y_U if wiring.measured_ambient == 1 else belief.U
    T = T if wiring.load_cell == 1 else np.nan
    return inner_loop_step(memory, T_d, belief.n, belief.v, U, valid, clock.dt, law, p, T, 0.0)


@equation
def _recorded(out, k, belief, answer, wiring):  # type: ignore[no-untyped-def]
    out[0, k], out[1, k], out[2, k] = answer.u, throttle_acting(answer.u, wiring.quantised == 1), answer.n_d
    out[3, k], out[9, k] = answer.alpha, answer.status
    out[4, k], out[5, k], out[6, k], out[10, k] = belief.n, belief.v, belief.U, belief.status


@equation
def _before_sample(memory, belief, T_d, y_U, T, k, clock, wiring, law, p, out):  # type: ignore[no-untyped-def]
    """Return the memory after the law's answer where it comes before the sample, recorded in `out`."""
    if wiring.bench == 1:
        memory, answer = _answer(memory, belief, T_d, y_U, T, clock, wiring, law, p)
        _recorded(out, k, belief, answer, wiring)
    return memory


@equation
def _with_sample(memory, belief, T_d, y_n, y_U, T, k, clock, wiring, observer, law, p, out):  # type: ignore[no-untyped-def]
    """Return (memory, belief) after the sample of period k."""
    out[7, k], out[8, k] = y_n, y_U
    if wiring.bench == 1:
        belief, _ = observer_step(belief, y_n, y_U, clock.dt, out[0, k], observer, p)
        return memory, belief
    last, dt = (out[0, k - 1], clock.dt) if k > 0 else (0.0, 0.0)
    belief, _ = observer_step(belief, y_n, y_U, dt, last, observer, p)
    memory, answer = _answer(memory, belief, T_d, y_U, T, clock, wiring, law, p)
    _recorded(out, k, belief, answer, wiring)
    return memory, belief


@equation
def _pushed(state, n, U, v):  # type: ignore[no-untyped-def]
    return PlantState(state.n + n, state.v + v, state.ambient + U, state.u, state.heat)


@compiled
def run_loop(  # type: ignore[no-untyped-def]
    T_d, noise, pushes, start, controller, belief, clock, wiring, observer, law, p_c, plant, gates, dense, read, out
):
    """Run all periods; fill `dense` (6, N S + 1), `read` (5, N S + 1) and `out` (len(COLUMNS), N).

    noise: `Disturbances`; pushes: what is added to dn/dt [rad/s^2], dU/dt and dv/dt [m/s^2] over each period, at its
    end, (3, N); observer, law: settings; p_c: what the controller believes; plant: `PlantSide`; dense: rows of
    `stepper.ROWS`; read: what sensors make of them, `dense` itself where no sensor has an effect.
    """
    dt, S = clock.dt / clock.steps, clock.steps
    throttle = np.empty((S, 1))
    state, acting, seen_U, seen_T, known = start, 0.0, 0.0, 0.0, 0
    p, e, substeps, memory = plant.p, plant.e, plant.substeps, plant.memory
    apart = dense.shape[0] != read.shape[0]
    for k in range(T_d.size):
        gate = gates[min(k, gates.size - 1) :][:1]
        first = k * S
        controller = _before_sample(controller, belief, T_d[k], seen_U, seen_T, k, clock, wiring, law, p_c, out)
        if wiring.bench == 1:
            throttle[: clock.delay], throttle[clock.delay :] = acting, out[1, k]
            state = advance(state, throttle, dt, substeps, p, e, gate, NOMINAL_SUPPLY, memory, dense, first)
        else:
            advance(state, throttle[:0], dt, substeps, p, e, gate, NOMINAL_SUPPLY, memory, dense, first)
        at = max(first + clock.sample, 0)
        if apart:
            sense(dense, known, at + 1, dt, plant.e_sensors, plant.sensors, read)
        known = max(known, at + 1)
        y_n = speed_read(read[0, at], noise.speed[k], wiring.quantised == 1)
        seen_U = noise.told[k]
        if not np.isfinite(seen_U):
            seen_U = flow_read(read[2, at], noise.flow[k], noise.eddies[k], wiring.quantised == 1)
        seen_T = read[3, at] + noise.load[k]
        controller, belief = _with_sample(
            controller, belief, T_d[k], y_n, seen_U, seen_T, k, clock, wiring, observer, law, p_c, out
        )
        if wiring.bench == 0:
            throttle[: clock.delay], throttle[clock.delay :] = acting, out[1, k]
            state = advance(state, throttle, dt, substeps, p, e, gate, NOMINAL_SUPPLY, memory, dense, first)
        acting = out[1, k]
        state = _pushed(state, pushes[0, k] * clock.dt, pushes[1, k] * clock.dt, pushes[2, k] * clock.dt)
    if apart:
        sense(dense, known, dense.shape[1], dt, plant.e_sensors, plant.sensors, read)
    return state
