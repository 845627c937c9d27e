r"""The vehicle as the outer loop knows it: C(nu) nu + D(nu) nu + g and products with M.

The coefficients c are those of the vehicle's set: M_RB, M_A, D_L, D_Q (6, 6), weight, buoyancy [N], r_G, r_B (3,) [m].

(2.11)  C(nu) nu = [nu_2 x a; nu_2 x b + nu_1 x a],   [a; b] = M nu
(2.15)  D(nu) nu = D_L nu + D_Q |nu| nu
(2.18)  g = -[f_G + f_B; r_G x f_G + r_B x f_B],   f_G + f_B = (W - B) J_1^T e_z
"""

from thruster_model.compilation import equation
from thruster_model.equations.attitude import rotated_back

__all__ = ["add_inertia", "model_terms", "restoring_for"]


@equation
def add_inertia(c, x, y):  # type: ignore[no-untyped-def]
    """Add M x to y (6,), M = M_RB + M_A."""
    for i in range(6):
        for j in range(6):
            y[i] += (c.M_RB[i, j] + c.M_A[i, j]) * x[j]


@equation
def restoring_for(c, d):  # type: ignore[no-untyped-def]
    """Return g (2.18) as a tuple of six [N, N m] where `d` are the body's axes of a unit vector that points down."""
    W, B = c.weight, c.buoyancy
    m = (W * c.r_G[0] - B * c.r_B[0], W * c.r_G[1] - B * c.r_B[1], W * c.r_G[2] - B * c.r_B[2])
    return (
        -(W - B) * d[0], -(W - B) * d[1], -(W - B) * d[2],
        -(m[1] * d[2] - m[2] * d[1]), -(m[2] * d[0] - m[0] * d[2]), -(m[0] * d[1] - m[1] * d[0]),
    )  # fmt: skip


@equation
def model_terms(c, q, nu, out):  # type: ignore[no-untyped-def]
    """Fill out (6,) with C(nu) nu + D(nu) nu + g [N, N m]."""
    out[:] = 0.0
    add_inertia(c, nu, out)
    a, b = (out[0], out[1], out[2]), (out[3], out[4], out[5])
    u, v, w, p, r, s = nu[0], nu[1], nu[2], nu[3], nu[4], nu[5]
    out[0], out[1], out[2] = r * a[2] - s * a[1], s * a[0] - p * a[2], p * a[1] - r * a[0]
    out[3] = r * b[2] - s * b[1] + v * a[2] - w * a[1]
    out[4] = s * b[0] - p * b[2] + w * a[0] - u * a[2]
    out[5] = p * b[1] - r * b[0] + u * a[1] - v * a[0]
    g = restoring_for(c, rotated_back(q, (0.0, 0.0, 1.0)))
    for i in range(6):
        out[i] += g[i]
        for j in range(6):
            out[i] += (c.D_L[i, j] + c.D_Q[i, j] * abs(nu[j])) * nu[j]
