"""An observer over a whole recording in one compiled loop, and one compiled step for callers in Python."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_estimation.belief import Belief, in_numbers
from thruster_estimation.observers import observer_step
from thruster_estimation.settings import checked
from thruster_model.compilation import compiled

__all__ = ["COLUMNS", "History", "compiled_step", "observe", "run_observer"]

COLUMNS = (
    "n", "v", "U", "P_nn", "P_nv", "P_nU", "P_vv", "P_vU", "P_UU", "status", "y_n", "y_U", "S_nn", "S_nU", "S_UU",
    "nis_n", "nis_U", "nis", "dof", "used_n", "used_U", "gated_n", "gated_U",
)  # fmt: skip
"""Rows of `out`: of the belief after each step, then of its innovation."""


@compiled
def compiled_step(belief, y_n, y_U, dt, u, settings, p):  # type: ignore[no-untyped-def]
    """Return (Belief, Innovation) as `observer_step` does: from Python in 15 µs instead of more than 1 ms.

    All numbers floats, settings `checked`, belief as from `initial_belief` or `in_numbers`.
    """
    return observer_step(belief, y_n, y_U, dt, u, settings, p)


@compiled
def run_observer(y_n, y_U, u, dt, belief, settings, p, out):  # type: ignore[no-untyped-def]
    """Step through N periods, fill `out` (len(COLUMNS), N) and return the last belief.

    y_n, y_U, u, dt: shape (N,), as `observer_step` takes them.
    """
    for k in range(y_n.size):
        belief, i = observer_step(belief, y_n[k], y_U[k], dt[k], u[k], settings, p)
        out[0, k], out[1, k], out[2, k] = belief.n, belief.v, belief.U
        out[3, k], out[4, k], out[5, k] = belief.P_nn, belief.P_nv, belief.P_nU
        out[6, k], out[7, k], out[8, k] = belief.P_vv, belief.P_vU, belief.P_UU
        out[9, k] = belief.status
        out[10, k], out[11, k] = i.y_n, i.y_U
        out[12, k], out[13, k], out[14, k] = i.S_nn, i.S_nU, i.S_UU
        out[15, k], out[16, k], out[17, k], out[18, k] = i.nis_n, i.nis_U, i.nis, i.dof
        out[19, k], out[20, k], out[21, k], out[22, k] = i.used_n, i.used_U, i.gated_n, i.gated_U
    return belief


class History:
    """The columns of `COLUMNS` over N steps as attributes, each of shape (N,); `last`: the belief after them."""

    def __init__(self, table: NDArray[np.float64], last: Belief) -> None:
        table.setflags(write=False)
        self.table, self.last = table, last

    def __getattr__(self, name: str) -> NDArray[np.float64]:
        if name not in COLUMNS:
            raise AttributeError(f"history: no column {name!r}; it has {', '.join(COLUMNS)}")
        return np.asarray(self.table[COLUMNS.index(name)])


def observe(
    y_n: ArrayLike, y_U: ArrayLike, u: ArrayLike, dt: ArrayLike, belief: Belief, settings: Any, p: Any
) -> History:
    """Run an observer over N periods.

    Args:
        y_n: measured speeds [rad/s], y_U: measured ambient flows [m/s], u: throttles [V], dt: periods [s]; each of
            shape (N,) or a scalar, NaN = not measured.
        belief: before the first period.
        settings: one of the classes of `settings`.
        p: `ThrusterCoefficients`.
    """
    columns = np.broadcast_arrays(*(np.asarray(a, dtype=np.float64) for a in (y_n, y_U, u, dt)))
    if columns[0].ndim != 1:
        raise ValueError(f"observe: expected measurements of shape (N,), got {columns[0].shape}")
    n, U, throttle, period = (np.ascontiguousarray(c) for c in columns)
    out = np.empty((len(COLUMNS), n.size))
    last = run_observer(n, U, throttle, period, in_numbers(belief), checked(settings), p, out)
    return History(out, Belief(*last))
