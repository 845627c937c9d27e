r"""Rotor speed that gives a wanted thrust: the inverses of the thrust maps.

(3.6)   n_d = sgn(T_d) sqrt(|T_d / c_T + delta_T|), with the side's c_T and delta_T; n_d = 0 for T_d = 0

(4.22), (4.23) as printed, with c_v^T = 0 for HL:
        n_d = (c_nv v + sgn(T_d) sqrt((c_nv v)^2 + |4 c_n (c_v v|v| + T_d)|)) / (2 c_n)

Exact. With T' = T_d + c_v v|v| the HL and HQ maps read c_n n|n| - c_nv |n| v = T'. As |n| >= 0, n has the sign s of
T' and |n| solves c_n m^2 - s c_nv v m - |T'| = 0, whose only positive root is
        n_d = (c_nv v + s sqrt((c_nv v)^2 + 4 c_n |T'|)) / (2 c_n),      s = sgn(T').
The printed form has sgn(T_d) in place of sgn(T'): the two differ where T_d and c_v v|v| oppose each other.
At T_d = 0, n_d = 0 by definition: an idle command never spins a propeller. At T' = 0 the root jumps by
c_nv |v| / c_n (a turning propeller in a stream gives no thrust at two speeds); a controller needs hysteresis there.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.equations.dead_zone import dead_zone_inverse
from thruster_model.equations.selection import selected


@equation
def speed_for_thrust_map(thrust, p):  # type: ignore[no-untyped-def]
    """Return n_d [rad/s] of (3.6) for the wanted thrust [N]; the flow is taken as zero."""
    return np.sign(thrust) * np.sqrt(np.abs(dead_zone_inverse(thrust, p.c_T1, p.delta_T1, p.c_T2, p.delta_T2)))


@equation
def speed_for_thrust(thrust, v, c_n, c_nv, c_v):  # type: ignore[no-untyped-def]
    """Return the exact n_d [rad/s] for the wanted thrust [N] at axial flow v [m/s]; HL with c_v = 0."""
    needed = thrust + c_v * v * np.abs(v)
    root = _root(v, needed, np.sign(needed), c_n, c_nv)
    return selected((thrust == 0.0) | (needed == 0.0), 0.0, root)


@equation
def speed_for_thrust_as_printed(thrust, v, c_n, c_nv, c_v):  # type: ignore[no-untyped-def]
    """Return n_d [rad/s] of (4.22), (4.23) as printed, for reproducing the bench; not always an inverse."""
    return _root(v, thrust + c_v * v * np.abs(v), np.sign(thrust), c_n, c_nv)


@equation
def _root(v, needed, sign, c_n, c_nv):  # type: ignore[no-untyped-def]
    loss = c_nv * v
    return (loss + sign * np.sqrt(loss * loss + 4.0 * c_n * np.abs(needed))) / (2.0 * c_n)
