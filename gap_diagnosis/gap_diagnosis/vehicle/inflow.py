r"""What the water through thrusters does to a filter of the body: how it holds a vehicle, and what is not known of it.

The axial flow v of an idle thruster in a stream U leaves v = 0, an unstable equilibrium, at an instant that no model
foretells, and goes to where the stream carries it. Between both lies a doubt of v, and one of the thrust,

    sigma_T = |T(n, v + s) - T(n, v - s)| / 2,      s = v_stream / 2 while idle,      ds/dt = a s once driven

with a the slope of dv/dt over v. A filter takes sigma_T for a random force of the flow's own time.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.rules import FASTEST, FASTEST_FLOW, IDLE
from thruster_model.compilation import compiled
from thruster_model.pipeline import derivative, outputs
from thruster_model.vehicle_coefficients import VehicleCoefficients

__all__ = ["Inflow", "inflow", "thrusts_at"]

Array = NDArray[np.float64]
_SMALL, _SETTLING = 1e-4, 1.0  # step of v and U [m/s]; slowest rate at which a flow follows [1/s]
_HALVINGS = 20


class Inflow(NamedTuple):
    """Slopes dT/dU (K, N) [N s/m] of thrusters whose flow follows; doubts (K, N) [N], deviations of thrusts by flows
    that are not known; deviations of those flows at the end (N,) [m/s]."""

    slopes: Array
    doubts: Array
    last: Array


@compiled
def _carried(U, p):  # type: ignore[no-untyped-def]
    """Return the axial flow [m/s] to which a stream carries the water of a thruster at rest."""
    low, high = _SMALL * np.sign(U), U
    if abs(U) <= _SMALL or derivative(0.0, low, U, 0.0, p)[1] * U <= 0.0:
        return 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if derivative(0.0, middle, U, 0.0, p)[1] * U > 0.0:
            low = middle
        else:
            high = middle
    return low


@compiled
def _inflow(n, v, U, p, period, s, slopes, doubts):  # type: ignore[no-untyped-def]
    for k in range(len(n)):
        rate = derivative(n[k], v[k], U[k], 0.0, p)[1]
        a = (derivative(n[k], v[k] + _SMALL, U[k], 0.0, p)[1] - rate) / _SMALL
        b = (derivative(n[k], v[k], U[k] + _SMALL, 0.0, p)[1] - rate) / _SMALL
        thrust = outputs(n[k], v[k], U[k], 0.0, p)[2]
        by_flow = (outputs(n[k], v[k] + _SMALL, U[k], 0.0, p)[2] - thrust) / _SMALL
        slopes[k] = -by_flow * b / a if a < -_SETTLING else 0.0
        at = v[k]
        if abs(n[k]) < IDLE:
            at = 0.5 * _carried(U[k], p)
            s = max(s, abs(at))
        doubts[k] = 0.5 * abs(outputs(n[k], at + s, U[k], 0.0, p)[2] - outputs(n[k], at - s, U[k], 0.0, p)[2])
        s *= np.exp(min(a, 0.0) * period)
    return s


def inflow(
    thrusters: Sequence[Any], c: VehicleCoefficients, nu: Array, n: Array, v: Array, period: float,
    before: Array | None = None,
) -> Inflow:  # fmt: skip
    """Return both for rotor speeds n (K, N) [rad/s], axial flows v (K, N) [m/s] and motion nu (K, 6), each period [s].

    before: deviations of the flows at the first instant (N,) [m/s]; None: they are known.
    """
    U, v = np.clip(nu, -FASTEST, FASTEST) @ c.inflow, np.clip(v, -FASTEST_FLOW, FASTEST_FLOW)
    found = Inflow(np.zeros(n.shape), np.zeros(n.shape), np.zeros(n.shape[1]) if before is None else before.copy())
    for i, p in enumerate(thrusters):
        if getattr(p, "k_Tv", 0.0):
            each = np.zeros((2, len(n)))
            found.last[i] = _inflow(n[:, i].copy(), v[:, i].copy(), U[:, i].copy(), p, period, found.last[i], *each)
            found.slopes[:, i] = np.minimum(np.nan_to_num(each[0]), 0.0) * c.thrust_scale[i]
            found.doubts[:, i] = np.nan_to_num(each[1]) * c.thrust_scale[i]
    return found


def thrusts_at(thrusters: Sequence[Any], c: VehicleCoefficients, n: Array) -> Array:
    """Return thrusts (K, N) [N] at rotor speeds n (K, N) [rad/s] in water at rest, with no axial flow."""
    found = np.zeros(n.shape)
    for i, p in enumerate(thrusters):
        found[:, i] = _thrusts(n[:, i].copy(), p)
    return found * c.thrust_scale


@compiled
def _thrusts(n, p):  # type: ignore[no-untyped-def]
    out = np.zeros(len(n))
    for k in range(len(n)):
        out[k] = outputs(n[k], 0.0, 0.0, 0.0, p)[2]
    return out
