"""The thrust that each thruster can give at the present inflow: its steady states at full throttle either way.

On a vehicle the ambient flow U is kinematic, so that a steady state is one of rotor and axial flow alone. In a stream
that blows against it a thruster's largest thrust falls, and passes zero: at 3 V the HQ set gives 16.0 N at rest,
9.7 N at 0.2 m/s and -6.5 N at 0.5 m/s.
"""

from collections.abc import Sequence
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.compilation import compiled, equation
from thruster_model.pipeline import derivative, outputs

__all__ = ["ThrustLimits", "constant_limits", "limits_at", "limits_of_sets", "steady_thrust"]

Array = NDArray[np.float64]
_STEP = 1e-3  # s
_LONGEST = 20.0  # s
_SEED = 1e-3  # m/s, along the thrust: v = 0 is an equilibrium of an idle thruster


class ThrustLimits(NamedTuple):
    """Smallest and largest thrust [N] of each thruster over U, (N, G) each; U = first + k step [m/s], k < G."""

    first: float
    step: float
    reverse: Array
    forward: Array


@compiled
def steady_thrust(u, U, p):  # type: ignore[no-untyped-def]
    """Return the thrust [N] at throttle u [V] in the ambient flow U [m/s] once rotor and axial flow have settled."""
    n, v = 0.0, _SEED if u >= 0.0 else -_SEED
    dt = _STEP
    for _ in range(int(_LONGEST / dt)):
        n_1, v_1, _x = derivative(n, v, U, u, p)
        n_2, v_2, _x = derivative(n + 0.5 * dt * n_1, v + 0.5 * dt * v_1, U, u, p)
        n_3, v_3, _x = derivative(n + 0.5 * dt * n_2, v + 0.5 * dt * v_2, U, u, p)
        n_4, v_4, _x = derivative(n + dt * n_3, v + dt * v_3, U, u, p)
        n += dt / 6.0 * (n_1 + 2.0 * n_2 + 2.0 * n_3 + n_4)
        v += dt / 6.0 * (v_1 + 2.0 * v_2 + 2.0 * v_3 + v_4)
        if abs(n_1) < 1e-7 and abs(v_1) < 1e-9:
            break
    return outputs(n, v, U, u, p)[2]


def limits_of_sets(coefficients: Sequence[Any], u_max: float, *, flow: float = 1.5, step: float = 0.02) -> ThrustLimits:
    """Return the limits of thrusters with these coefficients at throttles up to `u_max` [V], for |U| <= `flow` [m/s].

    Beyond that flow the last one counts.

    Raises:
        ValueError: a throttle, flow or step that is not positive and finite, or coefficients whose thrust is not.
    """
    for name, value in (("u_max", u_max), ("flow", flow), ("step", step)):
        if not 0.0 < value < np.inf:
            raise ValueError(f"{name}: expected a finite number above 0; found {value}")
    half = max(int(np.ceil(flow / step - 1e-9)), 1)
    flows = step * np.arange(-half, half + 1)
    found: dict[int, tuple[Array, Array]] = {}
    for p in coefficients:
        if id(p) not in found:
            rows = [np.array([steady_thrust(u, float(U), p) for U in flows]) for u in (-float(u_max), float(u_max))]
            found[id(p)] = (np.minimum(*rows), np.maximum(*rows))
    reverse, forward = (np.array([found[id(p)][side] for p in coefficients]) for side in (0, 1))
    if not (np.all(np.isfinite(reverse)) and np.all(np.isfinite(forward))):
        raise ValueError("coefficients: expected finite steady thrusts; found some that are not")
    return ThrustLimits(float(flows[0]), float(step), reverse, forward)


def constant_limits(reverse: ArrayLike, forward: ArrayLike) -> ThrustLimits:
    """Return limits [N] that do not depend on the flow, shape (N,) each, reverse <= forward."""
    low, high = (np.array(side, dtype=np.float64) for side in np.broadcast_arrays(reverse, forward))
    if low.ndim != 1 or not np.all(low <= high) or not all(isfinite(x) for x in (*low, *high)):
        raise ValueError(f"limits: expected finite reverse <= forward of shape (N,); found {low} and {high}")
    return ThrustLimits(0.0, 1.0, np.column_stack((low, low)), np.column_stack((high, high)))


@equation
def limits_at(limits, U, lower, upper):  # type: ignore[no-untyped-def]
    """Fill lower, upper (N,) [N] with the limits at U (N,) [m/s]; an unknown U (NaN) counts as no flow."""
    last = limits.reverse.shape[1] - 1
    for i in range(U.shape[0]):
        flow = U[i] if np.isfinite(U[i]) else 0.0
        place = min(max((flow - limits.first) / limits.step, 0.0), float(last))
        k = min(int(place), last - 1)
        share = place - k
        lower[i] = limits.reverse[i, k] + share * (limits.reverse[i, k + 1] - limits.reverse[i, k])
        upper[i] = limits.forward[i, k] + share * (limits.forward[i, k + 1] - limits.forward[i, k])
