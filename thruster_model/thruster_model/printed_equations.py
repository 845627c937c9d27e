"""The equations of thruster models as text, for references and new sets; they are computed in `equations`.

Numbers in brackets are the thesis'.
"""

__all__ = [
    "AIRFOIL",
    "AMBIENT",
    "AXIAL",
    "CURVES",
    "DEAD_BAND_LOADS",
    "DEAD_ZONE",
    "FIRST_ORDER",
    "FOUR_QUADRANT",
    "LINEAR_LOADS",
    "PLAIN_LOADS",
    "QUADRATIC_LOADS",
    "RELATIVE_AXIAL",
    "ROTOR",
    "STATIC",
    "STEADY_AXIAL",
    "TABLE",
]


def _sides(of: str, slopes: str, edges: str) -> str:
    """Return a dead zone of `of` in words: slopes and edges of each side, 1 in reverse and 2 forward."""
    reverse, forward = (f"{slopes.format(k)} ({of} - {edges.format(k)})" for k in (1, 2))
    return f"{reverse} below {edges.format(1)}, {forward} above {edges.format(2)}, 0 between"


DEAD_ZONE = (f"gamma(u) = {_sides('u', 'c_u{}', 'delta_u{}')}  (3.9)",)
STATIC = (f"n = g(u) = {_sides('u', 'g_{}', 'delta_u{}')}",)
ROTOR = ("dn/dt = -k_n n - k_Q Q + gamma(u)  (3.8), (4.3)",)
FIRST_ORDER = (f"g(u) = {_sides('u', 'g_{}', 'delta_u{}')}", "dn/dt = rate (g(u) - n)")
DEAD_BAND_LOADS = (
    f"T = {_sides('n|n|', 'c_T{}', 'delta_T{}')}  (3.5)",
    f"Q = {_sides('n|n|', 'c_Q{}', 'delta_Q{}')}  (3.11)",
)
PLAIN_LOADS = ("T = c_T n|n|", "Q = c_Q n|n|")
LINEAR_LOADS = ("T = c_n_T n|n| - c_nv_T |n| v  (4.12)", "Q = c_n_Q n|n| - c_nv_Q |n| v  (4.13)")
QUADRATIC_LOADS = (
    "T = c_n_T n|n| - c_nv_T |n| v - c_v_T v|v|  (4.14)",
    "Q = c_n_Q n|n| - c_nv_Q |n| v - c_v_Q v|v|  (4.15)",
)
AXIAL = ("dv/dt = -k_v v - k_Uv |v| (v - k_w U) + k_Tv T  (4.4)",)
RELATIVE_AXIAL = ("dv/dt = -k_4 (v - U) |v - U| + k_5 T  (4.2)",)
STEADY_AXIAL = ("v = k_s U cos(inflow_angle) + k_r n",)
AMBIENT = ("dU/dt = -k_U U - k_UU U|U| + k_TU T  (4.5)",)
AIRFOIL = (
    "theta = atan2(v, 0.7 radius n)  (4.10), in all four quadrants; without v and n there is no load",
    "V^2 = v^2 + (0.7 radius n)^2  (4.11)",
    "L = 0.5 density pi radius^2 V^2 lift sin(2 (pitch - theta))  (4.8)",
    "D = 0.5 density pi radius^2 V^2 drag (1 - cos(2 (pitch - theta)))  (4.9)",
    "T = L cos(theta) - D sin(theta)  (4.6)",
    "Q = 0.7 radius (L sin(theta) + D cos(theta))  (4.7)",
)
FOUR_QUADRANT = (
    "w = 0.7 radius n",
    "beta = atan2(U, w)",
    "T = (U^2 + w^2) (a1_T cos(beta) + b1_T sin(beta) + a3_T cos(3 beta) + b3_T sin(3 beta))",
    "Q likewise, of a1_Q, b1_Q, a3_Q and b3_Q",
)
TABLE = ("n, T and Q over u: straight lines between the nodes, the last node beyond them",)
CURVES = (
    "x = command_scale (u - delta_u1) below delta_u1, command_scale (u - delta_u2) above delta_u2, 0 between",
    "dn/dt = rate (n_s(x, supply) - n), n_s: speed of the table at a command that is x beyond the table's dead zone",
    "T = thrust_scale F_s(n, supply), F_s: force of the table at the speed that the rotor has",
    "n_s, F_s: straight lines through the points (x, n, F) of the table's commands; between two supplies each point is "
    "on the line between theirs; beyond both the ends hold",
    "a table without speeds: n of F = 3.5e-4 N s^2 n|n|, which serves the lag alone",
    "the table's dead zone: the commands that move nothing at any of its supplies; what moves nothing at some of them "
    "alone are points of the table",
    "delta_u1, delta_u2: the zone's edges on this thruster; where they are not the table's, commands are shifted",
    "supply: the recorded voltage, on straight lines between its readings; nominal_supply in a run without any, "
    "and in no other run",
)
