"""The observers and inner loops of all thrusters in one tick, as their nodes do it, in one kernel.

At t_k, thruster by thruster: the observer predicts over the last period under the throttle held in it and takes in
y_n and y_U; the law answers on its estimates with u_k. At t_0 the observer begins from what is measured, as
`thruster_estimation.online` does, and no throttle is known; the law begins at rest over one period.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_control.inner_loop import AT_REST, Memory, inner_loop_step
from thruster_estimation.belief import Belief, Level, Status, level
from thruster_estimation.first_belief import measured_belief
from thruster_estimation.observers import observer_step
from thruster_model.compilation import compiled, equation

__all__ = ["ESTIMATES", "InnerLoops", "Wiring", "inner_loops_at_rest", "inner_loops_tick"]

ESTIMATES = ("n", "v", "U", "u", "n_d", "observer_status", "loop_status")
"""Columns of what a tick tells of a thruster: what the law took as n, v, U [rad/s, m/s, m/s], throttle [V],
desired speed [rad/s], statuses."""
_BELIEF = len(Belief._fields)
_INVALID = int(np.bitwise_or.reduce([int(s) for s in Status if level(int(s) | int(Status.USED_N)) == Level.INVALID]))


class Wiring(NamedTuple):
    """How the loops are built, 0 or 1 each.

    observes: there is an observer; sees_flow: it estimates v and U; measured_ambient: the law takes U as measured.
    """

    observes: int
    sees_flow: int
    measured_ambient: int


class InnerLoops(NamedTuple):
    """What N loops remember: fields of `Belief` (N, 14) and of `Memory` (N, 8), the throttle held [V] (N,)."""

    beliefs: NDArray[np.float64]
    memories: NDArray[np.float64]
    held: NDArray[np.float64]


def inner_loops_at_rest(count: int) -> InnerLoops:
    """Return the loops of so many thrusters before their first tick."""
    memories = np.tile(np.array(AT_REST, dtype=np.float64), (count, 1))
    return InnerLoops(np.zeros((count, _BELIEF)), memories, np.full(count, np.nan))


@equation
def _observed(loops, i, first, y_n, y_U, dt, observer, p):  # type: ignore[no-untyped-def]
    """Return the belief of thruster i after its observer's step, kept in `loops`."""
    b = loops.beliefs[i]
    if first:
        belief = measured_belief(y_n, y_U, np.nan, observer.unsigned != 0)
        dt = 0.0
    else:
        belief = Belief(
            b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7], b[8], int(b[9]), b[10], b[11], b[12], b[13]
        )  # fmt: skip
    belief, _ = observer_step(belief, y_n, y_U, dt, loops.held[i], observer, p)
    b[0], b[1], b[2] = belief.n, belief.v, belief.U
    b[3], b[4], b[5], b[6], b[7], b[8] = belief.P_nn, belief.P_nv, belief.P_nU, belief.P_vv, belief.P_vU, belief.P_UU
    b[9], b[10], b[11], b[12], b[13] = belief.status, belief.unseen_n, belief.unseen_U, belief.shut_n, belief.shut_U
    return belief


@compiled
def inner_loops_tick(loops, first, T_d, y_n, y_U, dt, wiring, observer, law, p, told):  # type: ignore[no-untyped-def]
    """Advance all loops by a tick; `loops.held` is then the throttle from now on [V].

    Args:
        loops: `InnerLoops`, changed in place.
        first: whether it is the first tick.
        T_d: wanted thrusts [N], y_n: measured speeds [rad/s], y_U: measured ambient flows [m/s], NaN: none; (N,) each.
        dt: period [s].
        wiring: `Wiring`; observer, law: settings; p: coefficients, the same for each thruster.
        told: columns of `ESTIMATES`, (N, len(ESTIMATES)), filled.
    """
    for i in range(T_d.size):
        n, v, U, status, valid = np.nan, np.nan, np.nan, 0, False
        if wiring.observes != 0:
            belief = _observed(loops, i, first, y_n[i], y_U[i], dt, observer, p)
            status = belief.status
            valid = status != 0 and status & _INVALID == 0
            n = belief.n
            if wiring.sees_flow != 0:
                v, U = belief.v, belief.U
        if wiring.measured_ambient != 0:
            U = y_U[i]
        m = loops.memories[i]
        memory = Memory(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7])
        memory, answer = inner_loop_step(memory, T_d[i], n, v, U, valid, dt, law, p, np.nan, 0.0)
        m[0], m[1], m[2], m[3] = memory.sigma, memory.n_d, memory.n_d_rate, memory.u
        m[4], m[5], m[6], m[7] = memory.side, memory.age, memory.v, memory.ambient
        loops.held[i] = answer.u
        told[i, 0], told[i, 1], told[i, 2], told[i, 3], told[i, 4] = n, v, U, answer.u, answer.n_d
        told[i, 5], told[i, 6] = status, answer.status
