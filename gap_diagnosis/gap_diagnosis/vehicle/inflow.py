r"""What the water through thrusters does to a filter of the body: how it holds a vehicle, and what is not known of it.

The axial flow v of a thruster in a stream U has two stable values where the propeller is slow: one that the stream
carries and one that the propeller drives, near 0. Which of them is taken hangs on less than a model knows, and may last
for ten seconds. So two flows more follow the flow's own equation, from v - d and v + d on with d = `rules.FLOW_KNOWN`.
They begin anew while they are that near to each other; where they part, the thrust is in doubt by what is equally
likely anywhere between theirs,

    sigma_T = |T(n, v_high) - T(n, v_low)| / sqrt(12)

until they meet again. A filter takes it for a random force of the flow's own time.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.rules import FASTEST, FASTEST_FLOW, FLOW_KNOWN
from rov_sim.vehicle.plant import VehicleSettings
from thruster_model.compilation import compiled
from thruster_model.pipeline import derivative, outputs

__all__ = ["Inflow", "inflow", "thrusts_at"]

Array = NDArray[np.float64]
_SMALL, _SETTLING = 1e-4, 1.0  # step of v and U [m/s]; slowest rate at which a flow follows [1/s]


class Inflow(NamedTuple):
    """Slopes dT/dU (K, N) [N s/m] of thrusters whose flow follows; doubts (K, N) [N], deviations of thrusts by flows
    that are not known; lowest and highest flows at the end (N, 2) [m/s]."""

    slopes: Array
    doubts: Array
    last: Array


@compiled
def _inflow(n, v, U, p, period, ends, slopes, doubts):  # type: ignore[no-untyped-def]
    for k in range(len(n)):
        rate = derivative(n[k], v[k], U[k], 0.0, p)[1]
        a = (derivative(n[k], v[k] + _SMALL, U[k], 0.0, p)[1] - rate) / _SMALL
        b = (derivative(n[k], v[k], U[k] + _SMALL, 0.0, p)[1] - rate) / _SMALL
        thrust = outputs(n[k], v[k], U[k], 0.0, p)[2]
        by_flow = (outputs(n[k], v[k] + _SMALL, U[k], 0.0, p)[2] - thrust) / _SMALL
        slopes[k] = -by_flow * b / a if a < -_SETTLING else 0.0
        if ends[1] - ends[0] > 2.0 * FLOW_KNOWN:
            thrusts = outputs(n[k], ends[0], U[k], 0.0, p)[2], outputs(n[k], ends[1], U[k], 0.0, p)[2]
            doubts[k] = abs(thrusts[1] - thrusts[0]) / np.sqrt(12.0)
        else:
            ends[0], ends[1] = v[k] - FLOW_KNOWN, v[k] + FLOW_KNOWN
        for i in range(2):
            rate = derivative(n[k], ends[i], U[k], 0.0, p)[1]
            a = (derivative(n[k], ends[i] + _SMALL, U[k], 0.0, p)[1] - rate) / _SMALL
            ends[i] += rate * (np.expm1(a * period) / a if a != 0.0 else period)


def inflow(
    settings: VehicleSettings, nu: Array, n: Array, v: Array, period: float, before: Array | None = None
) -> Inflow:  # fmt: skip
    """Return it for rotor speeds n (K, N) [rad/s], axial flows v (K, N) [m/s] and motion nu (K, 6), each period [s].

    before: lowest and highest flows at the first instant (N, 2) [m/s]; None: they are known.
    """
    c = settings.coefficients
    U, v = np.clip(nu, -FASTEST, FASTEST) @ c.inflow, np.clip(v, -FASTEST_FLOW, FASTEST_FLOW)
    ends = np.zeros((n.shape[1], 2)) if before is None else before.copy()
    found = Inflow(np.zeros(n.shape), np.zeros(n.shape), ends)
    for i, p in enumerate(settings.thrusters):
        if getattr(p, "k_Tv", 0.0):
            each = np.zeros((2, len(n)))
            _inflow(n[:, i].copy(), v[:, i].copy(), U[:, i].copy(), p, period, ends[i], *each)
            found.slopes[:, i] = np.minimum(np.nan_to_num(each[0]), 0.0) * c.thrust_scale[i]
            found.doubts[:, i] = np.nan_to_num(each[1]) * c.thrust_scale[i]
    return found


def thrusts_at(settings: VehicleSettings, n: Array) -> Array:
    """Return thrusts (K, N) [N] at rotor speeds n (K, N) [rad/s] in water at rest, with no axial flow."""
    found = np.zeros(n.shape)
    for i, p in enumerate(settings.thrusters):
        found[:, i] = _thrusts(n[:, i].copy(), p)
    return found * settings.coefficients.thrust_scale


@compiled
def _thrusts(n, p):  # type: ignore[no-untyped-def]
    out = np.zeros(len(n))
    for k in range(len(n)):
        out[k] = outputs(n[k], 0.0, 0.0, 0.0, p)[2]
    return out
