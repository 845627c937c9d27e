"""Parameters and another writing of the equations, for tests: the truth is not the code under test."""

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.parameter_set_io import load_parameter_set

Array = NDArray[np.float64]
HL: ThrusterCoefficients = load_parameter_set("hl").coefficients
HQ: ThrusterCoefficients = load_parameter_set("hq").coefficients
BENCH_HL: ThrusterCoefficients = load_parameter_set("hl_bench").coefficients
DT = 0.04


def drive(u: float, p: ThrusterCoefficients) -> float:
    """Return gamma(u) of (3.9)."""
    if u <= p.delta_u1:
        return p.c_u1 * (u - p.delta_u1)
    return p.c_u2 * (u - p.delta_u2) if u >= p.delta_u2 else 0.0


def rate(x: Array, u: float, p: ThrusterCoefficients) -> Array:
    """Return the right-hand side of (4.3) to (4.5) for HL and HQ."""
    n, v, U = x
    T = p.c_T1 * n * abs(n) - p.c_nv_T * abs(n) * v - p.c_v_T * v * abs(v)
    Q = p.c_Q1 * n * abs(n) - p.c_nv_Q * abs(n) * v - p.c_v_Q * v * abs(v)
    return np.array([
        -p.k_n * n - p.k_Q * Q + drive(u, p),
        -p.k_v * v - p.k_Uv * v * abs(v) + p.k_Uv * p.k_w * abs(v) * U + p.k_Tv * T,
        -p.k_U * U - p.k_UU * U * abs(U) + p.k_TU * T,
    ])  # fmt: skip


def rate_416(x: Array, u: float, p: ThrusterCoefficients) -> Array:
    """Return the same with (4.16)'s inflow, which has sgn(n) where (4.4) has sgn(v)."""
    found = rate(x, u, p)
    found[1] += p.k_Uv * p.k_w * x[2] * (x[1] * np.sign(x[0]) - abs(x[1]))
    return found


def truth(throttles: Array, start: tuple[float, float, float], p: ThrusterCoefficients, law=rate) -> Array:  # type: ignore[no-untyped-def]
    """Return the states (N, 3) at the end of each period of a held throttle, by scipy."""
    x, out = np.array(start), []
    for u in throttles:
        x = solve_ivp(lambda t, x, u=u: law(x, u, p), (0.0, DT), x, rtol=1e-9, atol=1e-9, max_step=2e-3).y[:, -1]
        out.append(x)
    return np.array(out)
