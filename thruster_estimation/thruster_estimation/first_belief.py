"""What an observer of the proper form believes before its first step: what is measured then, with wide deviations."""

from math import isfinite

from thruster_estimation.belief import Belief
from thruster_model.compilation import equation

__all__ = ["measured_belief"]

_LARGEST_FLOW = 0.5  # m/s
_DEVIATION_n, _DEVIATION_v, _DEVIATION_U = 20.0, 0.1, 0.1  # rad/s, m/s, m/s


@equation
def measured_belief(n, U, u, unsigned):  # type: ignore[no-untyped-def]
    """Return the belief from n [rad/s] and U [m/s] as measured, NaN: not; u: throttle before [V], NaN: not known.

    An unsigned speed gets the sign of u.
    """
    speed = n if isfinite(n) else 0.0
    ambient = min(max(U, -_LARGEST_FLOW), _LARGEST_FLOW) if isfinite(U) else 0.0
    turned = -speed if unsigned and u < 0.0 else speed
    return Belief(
        turned, 0.0, ambient, _DEVIATION_n**2, 0.0, 0.0, _DEVIATION_v**2, 0.0, _DEVIATION_U**2, 0, 0.0, 0.0, 0.0, 0.0
    )
