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
"""

import numpy as np

from thruster_model.compilation import equation


@equation
def airfoil_loads(n, v, radius, pitch, lift, drag, density):  # type: ignore[no-untyped-def]
    """Return (T [N], Q [N m]) of (4.6), (4.7); radius R [m], pitch p [rad], lift C_L, drag C_D, density [kg/m^3]."""
    tangential = 0.7 * radius * n
    theta = np.arctan2(v, tangential)
    pressure = 0.5 * density * np.pi * radius * radius * (v * v + tangential * tangential)
    lift_force = pressure * lift * np.sin(2.0 * (pitch - theta))
    drag_force = pressure * drag * (1.0 - np.cos(2.0 * (pitch - theta)))
    thrust = lift_force * np.cos(theta) - drag_force * np.sin(theta)
    torque = 0.7 * radius * (lift_force * np.sin(theta) + drag_force * np.cos(theta))
    return thrust, torque
