r"""The rotor speed that gives a wanted thrust, for every thrust map of the common form, with a side to stay on.

With the propeller's direction s = +1 or -1, n = s m, axial flow v = v_0 + k_r n and o = sgn(v), the map (3.5), (4.12),
(4.14), T = c_n (n|n| - delta) - c_nv |n| v - c_v v|v|, reads

    A m^2 - B m = R,    A = c_n - c_nv k_r - s o c_v k_r^2,    B = s c_nv v_0 + 2 o c_v k_r v_0,
                        R = s (T_d + o c_v v_0^2) + c_n |delta|

(3.6): v_0 = k_r = 0. (4.22), (4.23): v_0 = v, k_r = 0. Kim and Chung's steady flow: v_0 = k_s U cos(a), so that v and
n_d fit each other. A > 0 is assumed: the propeller is not choked by the flow that it makes.

T' = T_d + c_v v_0|v_0| is the thrust that the turning propeller must add to the one of the still propeller. Its sign
is the side of the only exact root for which n_d T' > 0. At T' = 0 that root jumps by c_nv |v_0| / A where the
propeller turns with the stream; the other side's root goes to zero. While |T'| < hysteresis such a propeller stays on
its side, on the larger root of the same equation, which is exact as long as it exists: B^2 + 4 A R >= 0.
"""

import math

from thruster_model.compilation import equation
from thruster_model.equations.thruster import ThrusterCoefficients

__all__ = ["side_for_thrust", "speed_on_side"]


@equation
def _sign(x):  # type: ignore[no-untyped-def]
    return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else 0.0)


@equation
def _larger_root(T_d, v_0, k_r, s, o, p: ThrusterCoefficients):  # type: ignore[no-untyped-def]
    """Return m [rad/s], the larger root for flow of sign `o`; 0 where there is none."""
    c_n, edge = (p.c_T2, p.delta_T2) if s > 0.0 else (p.c_T1, p.delta_T1)
    A = c_n - p.c_nv_T * k_r - s * o * p.c_v_T * k_r * k_r
    B = s * p.c_nv_T * v_0 + 2.0 * o * p.c_v_T * k_r * v_0
    R = s * (T_d + o * p.c_v_T * v_0 * v_0) + c_n * abs(edge)
    square = B * B + 4.0 * A * R
    if square < 0.0 or A <= 0.0:
        return 0.0
    return max((B + math.sqrt(square)) / (2.0 * A), 0.0)


@equation
def speed_on_side(T_d, v_0, k_r, side, p):  # type: ignore[no-untyped-def]
    """Return n_d [rad/s] of direction `side` (1.0 or -1.0) for T_d [N], v_0 [m/s], k_r [m]; 0 where it has none."""
    o = _sign(v_0)
    if o == 0.0:
        o = _sign(side * k_r)
    m = _larger_root(T_d, v_0, k_r, side, o, p)
    if (v_0 + k_r * side * m) * o < 0.0:
        m = _larger_root(T_d, v_0, k_r, side, -o, p)
    return side * m


@equation
def side_for_thrust(T_d, v_0, k_r, side, hysteresis, p):  # type: ignore[no-untyped-def]
    """Return the direction (1.0 or -1.0; 0.0 for no thrust) of n_d; `side` is the present one, 0.0 for none."""
    needed = T_d + p.c_v_T * v_0 * abs(v_0)
    wanted = _sign(needed)
    if side == 0.0 or wanted == side or (wanted != 0.0 and abs(needed) >= hysteresis):
        return wanted
    with_stream = side * v_0 > 0.0 and speed_on_side(T_d, v_0, k_r, side, p) != 0.0
    return side if with_stream else wanted
