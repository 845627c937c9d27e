r"""Open-water propeller in four quadrants: coefficients over the advance angle instead of the advance ratio.

K_T(J) = T / (rho n^2 D^4) is singular at n = 0. Over the advance angle beta = atan2(v_a, 0.7 pi n_rev D) the four-
quadrant coefficients C_T* and C_Q* (van Lammeren, van Manen and Oosterveld 1969, "The Wageningen B-screw series",
Transactions SNAME 77; Oosterveld 1970) are smooth and periodic:

    T = 0.5 rho (v_a^2 + w^2) A C_T*(beta),   Q = 0.5 rho (v_a^2 + w^2) A D C_Q*(beta),   w = 0.7 R n   (n in rad/s)

written as Fourier series. A propeller that works alike in both directions has only odd harmonics; two of them are kept,
and the constants 0.5 rho A and 0.5 rho A D are taken into the coefficients:

    T = (v^2 + w^2) (a1 cos b + b1 sin b + a3 cos 3b + b3 sin 3b),   b = atan2(v, w)

and computed without angles, by cos b = w / V, sin b = v / V, V^2 = v^2 + w^2 and what these give for 3b.
"""

import numpy as np

from thruster_model.compilation import equation

_LEAST = 1e-100
"""[m/s] Where all that is divided by it is zero."""


@equation
def four_quadrant_load(n, v, radius, a1, b1, a3, b3):  # type: ignore[no-untyped-def]
    """Return the thrust [N] or torque [N m] for rotor speed n [rad/s] and inflow v [m/s]; radius R [m]."""
    w = 0.7 * radius * n
    speed = np.sqrt(v * v + w * w)
    c, s = w / np.maximum(speed, _LEAST), v / np.maximum(speed, _LEAST)
    third = a3 * c * (4.0 * c * c - 3.0) + b3 * s * (3.0 - 4.0 * s * s)
    return speed * speed * (a1 * c + b1 * s + third)
