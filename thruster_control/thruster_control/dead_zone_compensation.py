r"""The dead-zone-compensating controller of the rotor's speed (thesis, section 3.3.1).

(3.12)  u = gamma^-1(alpha)                                             [V]
(3.13)  alpha = dn_d/dt + k_n n + k_Q Q(n) - k_u Delta_n                [rad/s^2],   Delta_n = n - n_d

State n [rad/s], set point n_d [rad/s] and its rate dn_d/dt [rad/s^2], gain k_u > 0 [1/s]; Q(n) is (3.11), the torque
without axial flow [N m]; gamma^-1 is (3.10). Positive throttle turns the propeller forward.

Theorem 1: with u unlimited and the parameters known, d(Delta_n)/dt = -k_u Delta_n. Corollary 1.1: an error of dn_d/dt
below delta leaves |Delta_n| <= delta / k_u in the end (not from the start, as its proof shows). It is the plant (3.8)
that is inverted: coefficients with k_2 != 0 or drive_gain != 1 are not compensated for.

The throttle is not limited here, neither in size nor in rate: that is the caller's. It jumps by delta_u2 - delta_u1
where alpha changes sign, so noise in n makes it chatter about n_d = 0.

NaN in n, n_d, dn_d/dt or k_u makes alpha NaN, and the throttle then is 0 V: a thruster whose speed or set point is
unknown is left to run down. Infinite inputs give an infinite throttle or, where they cancel, 0 V. The coefficients are
taken as checked.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.equations.selection import selected
from thruster_model.equations.thruster import input_map_inverse, torque

__all__ = ["compensated_throttle", "demanded_drive"]


@equation
def demanded_drive(n, n_d, n_d_rate, k_u, p):  # type: ignore[no-untyped-def]
    """Return alpha of (3.13) [rad/s^2]; arguments broadcast, `p` = ThrusterCoefficients, NaN stays NaN."""
    return n_d_rate + p.k_n * n + p.k_Q * torque(n, 0.0, p) - k_u * (n - n_d)


@equation
def compensated_throttle(n, n_d, n_d_rate, k_u, p):  # type: ignore[no-untyped-def]
    """Return u of (3.12) [V], unlimited; arguments broadcast, `p` = ThrusterCoefficients, 0 V where one is NaN."""
    u = input_map_inverse(demanded_drive(n, n_d, n_d_rate, k_u, p), p)
    return selected(np.isnan(u), 0.0, u)
