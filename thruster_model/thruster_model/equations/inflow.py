r"""Other ways to the axial flow v than (4.4).

(4.2)  dv/dt = -k_4 (v - U)|v - U| + k_5 T                       two-state model (Healey et al.)

Steady flow after Kim and Chung (2006, "Accurate and practical thruster modeling for underwater vehicles", Ocean
Engineering 33, 566-586; thesis 6.2): v is a linear combination of ambient flow and rotor speed,

       v = k_s U cos(a) + k_r n

with a the angle of the ambient flow to the thruster's axis: only the axial part of U takes part. Put into the thrust
map (4.14) this is their thrust over the advance ratio J = v / (n D), K_T(J) n|n| with K_T quadratic in J, multiplied
out, and so without a singularity at n = 0. The loss of thrust against still water, c_nv |n| (v - k_r n) + ...,
shrinks with cos(a), vanishes across the axis and turns into a gain in flow from behind. Their further correction near
critical angles is a table for their propeller, which is not reproduced here.
"""

import numpy as np

from thruster_model.compilation import equation


@equation
def relative_axial_acceleration(v, ambient, force, k_4, k_5):  # type: ignore[no-untyped-def]
    """Return dv/dt [m/s^2] of (4.2); `ambient` = U [m/s], `force` = T [N], k_4 [1/m], k_5 [m/(N s^2)]."""
    slip = v - ambient
    return -k_4 * slip * np.abs(slip) + k_5 * force


@equation
def steady_axial_flow(n, ambient, k_s, k_r, angle):  # type: ignore[no-untyped-def]
    """Return v [m/s] of the steady flow; k_s dimensionless, k_r [m], inflow angle a [rad]."""
    return k_s * ambient * np.cos(angle) + k_r * n
