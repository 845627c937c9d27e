r"""Thrust and torque of a propeller blade as an airfoil: (4.6) to (4.11).

(4.10)  theta = atan2(v, 0.7 R n)                                  inflow angle at 70 % of the radius [rad]
(4.11)  V^2 = v^2 + (0.7 R n)^2                                    relative speed squared [m^2/s^2]
(4.8)   L = 0.5 rho pi R^2 V^2 C_L sin(2 (p - theta))              lift [N]
(4.9)   D = 0.5 rho pi R^2 V^2 C_D (1 - cos(2 (p - theta)))        drag [N]
(4.6)   T = L cos(theta) - D sin(theta)                            [N]
(4.7)   Q = 0.7 R (L sin(theta) + D cos(theta))                    [N m]

As printed, with theta over all four quadrants and one pitch p, L and D at v = 0 do not change sign with n: sin(2 (p -
pi)) = sin(2 p) while cos(theta) does, so thrust does change sign, as it should, and so does torque through D. The
singular V = 0 is no problem: both loads vanish with V^2.

They are computed without angles. With w = 0.7 R n, a = w sin p - v cos p = V sin(p - theta) and b = w cos p + v sin p =
V cos(p - theta), so that L and D are 2 C_L a b and 2 C_D a^2 times 0.5 rho pi R^2:

    T = rho pi R^2 a (C_L b w - C_D a v) / V,      Q = 0.7 R rho pi R^2 a (C_L b v + C_D a w) / V
"""

import numpy as np

from thruster_model.compilation import equation

_LEAST = 1e-100
"""[m/s] Where all that is divided by it is zero."""


@equation
def airfoil_loads(n, v, radius, pitch, lift, drag, density):  # type: ignore[no-untyped-def]
    """Return (T [N], Q [N m]) of (4.6), (4.7); radius R [m], pitch p [rad], lift C_L, drag C_D, density [kg/m^3]."""
    w = 0.7 * radius * n
    a = w * np.sin(pitch) - v * np.cos(pitch)
    b = w * np.cos(pitch) + v * np.sin(pitch)
    share = density * np.pi * radius * radius * a / np.maximum(np.sqrt(v * v + w * w), _LEAST)
    return share * (lift * b * w - drag * a * v), 0.7 * radius * share * (lift * b * v + drag * a * w)
