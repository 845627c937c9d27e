r"""The input map and the instants that make a plant's rotor follow the recorded throttle of closed-loop runs.

A nuisance: gamma of the real thruster on the day is not known, nor when y_k was sampled. Both are fitted to the
tachometer alone, with all other coefficients as they are: over c_u1, delta_u1, c_u2, delta_u2 and the time tau from
u_k's sending to y_k's sample, least soft-L1 squares of |n(t_k + tau)| - y_k, from rest, the throttle as it was sent.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from rov_sim.bench_study.controllers import InputMap
from rov_sim.bench_study.real_runs import RealRun
from rov_sim.rig_sensors import throttle_acting
from thruster_model.flow_tank import simulate

__all__ = ["FittedMap", "fitted_map"]

Array = NDArray[np.float64]
_STEP = 1e-3  # s
_KNEE = 3.0  # rad/s
_LARGEST_TIME = 0.2  # s


class FittedMap(NamedTuple):
    """gamma, tau [s], root mean square of what is left [rad/s], and of what was there before the fit [rad/s]."""

    input_map: InputMap
    tau: float
    left: float
    before: float


def fitted_map(runs: Sequence[RealRun], coefficients: Any, effects: Any) -> FittedMap:
    """Return the map of a plant for these recordings; `effects`: `ActiveEffects` of the truth."""
    sent = [np.repeat([throttle_acting(float(u), True) for u in run.u], round(run.period / _STEP)) for run in runs]

    def residuals(x: Array) -> Array:
        p = coefficients._replace(**InputMap(*map(float, x[:4]))._asdict())
        found = []
        for run, u in zip(runs, sent, strict=True):
            n = simulate(p, u, _STEP, effects=effects.plant).n
            at = run.period * np.arange(run.u.size) + x[4]
            found.append(np.interp(at, _STEP * np.arange(n.size), np.abs(n)) - run.y_n)
        return np.concatenate(found)

    c = coefficients
    start = np.array([c.c_u1, c.delta_u1, c.c_u2, c.delta_u2, 0.0])
    lower = [0.5 * c.c_u1, -1.5, 0.5 * c.c_u2, 0.3, -_LARGEST_TIME]
    upper = [2.0 * c.c_u1, -0.3, 2.0 * c.c_u2, 1.5, _LARGEST_TIME]
    scale = [100.0, 0.1, 100.0, 0.1, 0.01]
    solved = least_squares(residuals, start, bounds=(lower, upper), x_scale=scale, loss="soft_l1", f_scale=_KNEE,
                           diff_step=1e-4)  # fmt: skip
    left, before = (float(np.sqrt(np.mean(residuals(x) ** 2))) for x in (solved.x, start))
    return FittedMap(InputMap(*map(float, solved.x[:4])), float(solved.x[4]), left, before)
