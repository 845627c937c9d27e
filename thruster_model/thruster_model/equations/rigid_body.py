r"""Mass and inertia of a rigid body whose origin need not be its centre of mass, and what its momentum costs in turns.

nu = (nu_1, nu_2): velocity [m/s] and rate [rad/s] of the origin in body axes; S(a) b = a x b.

(2.7)   M_RB = [[m I, -m S(r_G)], [m S(r_G), I_O]],   I_O = I_G - m S(r_G)^2 about the origin
(2.12)  C_RB(nu) nu = [m nu_2 x nu_1 - m nu_2 x (r_G x nu_2); m r_G x (nu_2 x nu_1) + nu_2 x I_O nu_2]

(2.7) and (2.12) print I_G in the rotational blocks; that holds for r_G = 0 only. With [a; b] = M nu, for M_RB as for
the symmetric M_A, and for their sum,

        C(nu) nu = [nu_2 x a; nu_2 x b + nu_1 x a]
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.compilation import equation
from thruster_model.equations.attitude import cross

__all__ = ["coriolis", "coriolis_matrix", "moved_mass", "rigid_body_mass", "skew"]

Array = NDArray[np.float64]


def skew(a: ArrayLike) -> Array:
    """Return S(a) (3, 3) of (2.9)."""
    x, y, z = np.asarray(a, dtype=np.float64)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rigid_body_mass(mass: float, r_G: ArrayLike, I_G: ArrayLike) -> Array:
    """Return M_RB (6, 6) of (2.7).

    Args:
        mass: m [kg].
        r_G: centre of mass from the origin, body axes [m], shape (3,).
        I_G: inertia about the centre of mass [kg m^2], shape (3, 3).
    """
    S = skew(r_G)
    I_O = np.asarray(I_G, dtype=np.float64) - mass * S @ S
    return np.block([[mass * np.eye(3), -mass * S], [mass * S, I_O]])


def moved_mass(M_RB: ArrayLike, r_G: ArrayLike, r_new: ArrayLike) -> Array:
    """Return M_RB of the same body with its centre of mass moved from `r_G` to `r_new` [m]."""
    M = np.asarray(M_RB, dtype=np.float64)
    S = skew(r_G)
    return rigid_body_mass(M[0, 0], r_new, M[3:, 3:] + M[0, 0] * S @ S)


def coriolis_matrix(M: ArrayLike, nu: ArrayLike) -> Array:
    """Return C(nu) (6, 6) in the form of (2.13), which serves M_RB as well as M_A; M is symmetric."""
    a, b = np.split(np.asarray(M, dtype=np.float64) @ np.asarray(nu, dtype=np.float64), 2)
    return np.block([[np.zeros((3, 3)), -skew(a)], [-skew(a), -skew(b)]])


@equation
def coriolis(a, b, nu_1, nu_2):  # type: ignore[no-untyped-def]
    """Return C(nu) nu as (force [N], moment [N m]) from [a; b] = M nu; all are vectors of three."""
    x, y = cross(nu_2, b), cross(nu_1, a)
    return cross(nu_2, a), (x[0] + y[0], x[1] + y[1], x[2] + y[2])
