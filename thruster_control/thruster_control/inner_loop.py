r"""One step of an inner loop: from a wanted thrust and the estimates to the throttle, for every law.

For kernels and for plain Python alike; `compiled_step` is the compiled step for callers from Python.

What it does, in this order, is also what is answered for inputs that fail:

    dt not a positive finite time     0 V at once; the memory is emptied                              BAD_PERIOD
    T_d NaN or infinite               throttle runs down to zero at `run_down`                        NO_SET_POINT
    |T_d| <= idle_thrust              throttle goes to zero, n_d = 0: an idle command never spins     IDLE
    estimate invalid, not finite or   feed-forward of T_d with the last flow, the integral frozen,    HOLDING
      older than `oldest_estimate`      for `longest_hold`;
                                      then the throttle runs down to zero                             RUN_DOWN
    otherwise                         the law; LIMITED where the throttle or its rate was             RUNNING, LIMITED

Before the first usable estimate nothing is held: the throttle stays at zero. An estimate counts as unusable only for
a law that needs it. The integral stops while the limits keep the drive from following and the error would push it
further (conditional integration); it is emptied with time constant `bleed` while the propeller idles or runs down.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from thruster_control.laws import demand, usable
from thruster_model.compilation import compiled, equation
from thruster_model.equations.dead_zone import ramp_limited
from thruster_model.equations.thruster import input_map

__all__ = ["AT_REST", "Memory", "Output", "Status", "compiled_step", "inner_loop_step"]


class Status(IntEnum):
    """What a step did."""

    RUNNING = 0
    LIMITED = 1
    IDLE = 2
    HOLDING = 3
    RUN_DOWN = 4
    NO_SET_POINT = 5
    BAD_PERIOD = 6


_RUNNING, _LIMITED, _IDLE, _HOLDING, _RUN_DOWN, _NO_SET_POINT, _BAD_PERIOD = map(int, Status)


class Memory(NamedTuple):
    """What a loop remembers.

    sigma: the law's integral [rad, or N s of a thrust loop]; n_d [rad/s] and its filtered rate [rad/s^2], n_d NaN for
    none; u: last throttle [V]; side: direction of n_d, 0.0 for idle; age [s] of the last usable estimate; v, ambient
    [m/s]: the flow then.
    """

    sigma: float
    n_d: float
    n_d_rate: float
    u: float
    side: float
    age: float
    v: float
    ambient: float


AT_REST = Memory(0.0, math.nan, 0.0, 0.0, 0.0, math.inf, 0.0, 0.0)


class Output(NamedTuple):
    """Throttle u [V], desired speed n_d [rad/s], demanded drive alpha [rad/s^2], `Status`."""

    u: float
    n_d: float
    alpha: float
    status: int


@equation
def _to_zero(memory, rate, age, status, v, ambient, n_d, dt, settings):  # type: ignore[no-untyped-def]
    """Return (memory, output) with the throttle on its way to zero at `rate` [V/s]."""
    u = ramp_limited(memory.u, 0.0, rate, dt)
    sigma = memory.sigma * math.exp(-dt / settings.limits.bleed)
    return Memory(sigma, n_d, 0.0, u, 0.0, age, v, ambient), Output(u, 0.0, 0.0, status)


@equation
def inner_loop_step(memory, T_d, n, v, U, valid, dt, settings, p, T=np.nan, age=0.0, supply=1.0):  # type: ignore[no-untyped-def]
    """Return (memory, output) after a control period.

    Args:
        memory: of the former step, `AT_REST` at first.
        T_d: wanted thrust [N].
        n: estimated or measured rotor speed [rad/s], signed.
        v: estimated axial flow [m/s].
        U: estimated or measured ambient flow [m/s].
        valid: whether the estimates may be used.
        dt: time since the former step [s].
        settings: of a law (`thruster_control.settings`); its class chooses the law.
        p: coefficients, `ParameterSet.coefficients`; `SteadyFlowLaw` needs a steady-flow set.
        T: measured thrust [N], fed back by `ThrustLaw`.
        age: how old the estimates are [s].
        supply: voltage of the supply over the nominal one, for `ForceTableLaw`.

    NaN means unknown in each of them. Floats throughout: integers make kernels compile anew.
    """
    limits = settings.limits
    if not (dt > 0.0 and dt < np.inf):
        stopped = Memory(0.0, np.nan, 0.0, 0.0, 0.0, memory.age, memory.v, memory.ambient)
        return stopped, Output(0.0, 0.0, 0.0, _BAD_PERIOD)
    feedback = usable(n, v, U, T, bool(valid) and age <= limits.oldest_estimate, settings, p)
    unseen, flow, ambient = memory.age + dt, memory.v, memory.ambient
    if feedback:
        unseen = 0.0
        flow = v if math.isfinite(v) else 0.0
        ambient = U if math.isfinite(U) else 0.0
    run_down = min(limits.run_down, limits.u_dot_max)
    if not math.isfinite(T_d):
        return _to_zero(memory, run_down, unseen, _NO_SET_POINT, flow, ambient, np.nan, dt, settings)
    if unseen > limits.longest_hold:
        return _to_zero(memory, run_down, unseen, _RUN_DOWN, flow, ambient, np.nan, dt, settings)
    rate = min(limits.u_dot_max, p.u_dot_max)
    start = limits.idle_thrust if memory.side != 0.0 else 2.0 * limits.idle_thrust
    if abs(T_d) <= start:
        return _to_zero(memory, rate, unseen, _IDLE, flow, ambient, 0.0, dt, settings)
    wanted = demand(memory, T_d, n, flow, ambient, T, supply, feedback, dt, settings, p)
    if not (math.isfinite(wanted.u) and math.isfinite(wanted.n_d_rate)):
        return _to_zero(memory, run_down, unseen, _RUN_DOWN, flow, ambient, np.nan, dt, settings)
    u = min(max(wanted.u, -limits.u_max), limits.u_max)
    if abs(u - memory.u) > rate * dt:  # else exactly what is wanted: rounding would pass for a limit
        u = ramp_limited(memory.u, u, rate, dt)
    excess = wanted.alpha - input_map(u, p) if u != wanted.u else 0.0
    sigma = memory.sigma
    if dt <= limits.longest_period and (excess == 0.0 or excess * wanted.error > 0.0):
        sigma += dt * wanted.error
    status = _HOLDING if not feedback else (_RUNNING if u == wanted.u else _LIMITED)
    after = Memory(sigma, wanted.n_d, wanted.n_d_rate, u, wanted.side, unseen, flow, ambient)
    return after, Output(u, wanted.n_d, wanted.alpha, status)


@compiled
def compiled_step(memory, T_d, n, v, U, valid, dt, settings, p, T, age, supply=1.0):  # type: ignore[no-untyped-def]
    """Return (memory, output) of `inner_loop_step`, compiled; the same arguments, all given but the last."""
    return inner_loop_step(memory, T_d, n, v, U, valid, dt, settings, p, T, age, supply)
