r"""What water does to a body: drag, weight and buoyancy, current.

nu_r = nu - nu_c is the velocity relative to the water, in body axes.

(2.15)-(2.17)   D(nu_r) nu_r = (D_L + D_Q |nu_r|) nu_r          D_L, D_Q (6, 6), positive definite, diagonal as a rule
(2.18)-(2.20)   g = -[f_G + f_B; r_G x f_G + r_B x f_B],        f_G = J_1^T (0, 0, W),  f_B = J_1^T (0, 0, -B)
                nu_c = [J_1^T v_c; 0],  dnu_c/dt = [-nu_2 x J_1^T v_c; 0]       v_c: steady current, earth axes [m/s]

SNAME derivatives are negative numbers: D_L = -diag(X_u ...), D_Q = -diag(X_u|u| ...), M_A = -diag(X_udot ...).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.compilation import equation
from thruster_model.equations.attitude import cross, rotated_back

__all__ = ["current_in_body", "drag", "restoring"]

Array = NDArray[np.float64]


def drag(D_L: ArrayLike, D_Q: ArrayLike, nu_r: ArrayLike) -> Array:
    """Return D(nu_r) nu_r [N, N m] of (2.15), shape (6,)."""
    x = np.asarray(nu_r, dtype=np.float64)
    return np.asarray(np.asarray(D_L) @ x + np.asarray(D_Q) @ (np.abs(x) * x))


@equation
def restoring(q, W, B, r_G, r_B):  # type: ignore[no-untyped-def]
    """Return g of (2.18) as (force [N], moment [N m]); W, B [N]; r_G, r_B: vectors of three [m]."""
    down = rotated_back(q, (0.0, 0.0, 1.0))
    excess = W - B
    arm = (W * r_G[0] - B * r_B[0], W * r_G[1] - B * r_B[1], W * r_G[2] - B * r_B[2])
    moment = cross(arm, down)
    return (-excess * down[0], -excess * down[1], -excess * down[2]), (-moment[0], -moment[1], -moment[2])


@equation
def current_in_body(q, v_c):  # type: ignore[no-untyped-def]
    """Return J_1^T v_c [m/s], the steady current of earth axes as the body sees it."""
    return rotated_back(q, (v_c[0], v_c[1], v_c[2]))
