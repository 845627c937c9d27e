r"""Piecewise-linear dead zone, the shape of the input map, the thrust map and the torque map.

(3.9)   gamma(u) = c_1 (u - delta_1)   for u <= delta_1
                 = 0                   for delta_1 < u < delta_2
                 = c_2 (u - delta_2)   for u >= delta_2

(3.10)  gamma^-1(a) = a / c_1 + delta_1 for a < 0,   0 for a = 0,   a / c_2 + delta_2 for a > 0

with c_1, c_2 > 0, delta_1 <= 0 <= delta_2. (3.5) and (3.11) are the same function of n|n|.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.equations.selection import selected


@equation
def dead_zone(x, c_1, delta_1, c_2, delta_2):  # type: ignore[no-untyped-def]
    """Return (3.9) at x; arguments broadcast, slopes in output unit per unit of x, edges in the unit of x."""
    return c_1 * np.minimum(x - delta_1, 0.0) + c_2 * np.maximum(x - delta_2, 0.0)


@equation
def dead_zone_inverse(a, c_1, delta_1, c_2, delta_2):  # type: ignore[no-untyped-def]
    """Return (3.10) at a: the smallest |x| that gives a, and 0 for a = 0; arguments broadcast."""
    return selected(a < 0.0, a / c_1 + delta_1, selected(a > 0.0, a / c_2 + delta_2, a))


@equation
def dead_zone_crossing_time(delta_1, delta_2, rate):  # type: ignore[no-untyped-def]
    """Return (3.20), the longest stay [s] in the dead zone [V] while ramping at `rate` [V/s]."""
    return (delta_2 - delta_1) / rate


@equation
def ramp_limited(u, u_commanded, rate, dt):  # type: ignore[no-untyped-def]
    """Return the throttle [V] after `dt` [s] of moving from `u` towards `u_commanded` at most at `rate` [V/s]."""
    return u + np.minimum(np.maximum(u_commanded - u, -rate * dt), rate * dt)
