r"""The vehicle as the outer loop knows it: what (2.22) cancels, and products with M.

    M_RB dnu/dt + M_A (dnu/dt - dnu_c/dt) + C_RB(nu) nu + C_A(nu_r) nu_r + D(nu_r) nu_r + g = tau,   nu_r = nu - nu_c

so that C nu + D nu + g of (2.22) stands for all but M dnu/dt. The current v_c is that of the coefficients, zero as a
rule: what is not known is not cancelled.
"""

from thruster_model.compilation import equation
from thruster_model.equations.attitude import cross
from thruster_model.equations.hydrodynamics import current_in_body, restoring
from thruster_model.equations.rigid_body import coriolis

__all__ = ["add_inertia", "model_terms"]


@equation
def add_inertia(c, x, y):  # type: ignore[no-untyped-def]
    """Add M x to y (6,), M = M_RB + M_A."""
    for i in range(6):
        for j in range(6):
            y[i] += (c.M_RB[i, j] + c.M_A[i, j]) * x[j]


@equation
def _halves(matrix, x):  # type: ignore[no-untyped-def]
    """Return the product of a matrix (6, 6) and a tuple of six as two vectors of three."""
    y = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for j in range(6):
        y = (
            y[0] + matrix[0, j] * x[j], y[1] + matrix[1, j] * x[j], y[2] + matrix[2, j] * x[j],
            y[3] + matrix[3, j] * x[j], y[4] + matrix[4, j] * x[j], y[5] + matrix[5, j] * x[j],
        )  # fmt: skip
    return (y[0], y[1], y[2]), (y[3], y[4], y[5])


@equation
def model_terms(c, q, nu, out):  # type: ignore[no-untyped-def]
    """Fill out (6,) with all but M dnu/dt of the vehicle's equation of motion [N, N m]."""
    nu_2 = (nu[3], nu[4], nu[5])
    v_c = current_in_body(q, c.current)
    nu_r = (nu[0] - v_c[0], nu[1] - v_c[1], nu[2] - v_c[2], nu[3], nu[4], nu[5])
    turning = cross(nu_2, v_c)  # -dnu_c/dt
    a, b = _halves(c.M_RB, (nu[0], nu[1], nu[2], nu[3], nu[4], nu[5]))
    a_r, b_r = _halves(c.M_A, nu_r)
    body = coriolis(a, b, (nu[0], nu[1], nu[2]), nu_2)
    water = coriolis(a_r, b_r, (nu_r[0], nu_r[1], nu_r[2]), nu_2)
    g = restoring(q, c.weight, c.buoyancy, c.r_G, c.r_B)
    for i in range(3):
        out[i] = body[0][i] + water[0][i] + g[0][i]
        out[3 + i] = body[1][i] + water[1][i] + g[1][i]
    for i in range(6):
        for j in range(6):
            out[i] += (c.D_L[i, j] + c.D_Q[i, j] * abs(nu_r[j])) * nu_r[j]
        for j in range(3):
            out[i] += c.M_A[i, j] * turning[j]
