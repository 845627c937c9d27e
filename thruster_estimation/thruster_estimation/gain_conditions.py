r"""The conditions under which the nonlinear observer converges from everywhere, and gains kept within them.

(4.18)  |k_11| < sqrt(2 k_v beta)        (4.19)  k_21 > beta / 2 - k_U,     for some beta > 0
which is, without beta,                  k_11^2 < 4 k_v (k_21 + k_U)  and  k_21 > -k_U
"""

from math import copysign, sqrt
from typing import NamedTuple

from thruster_model.compilation import equation

__all__ = ["GainCheck", "check_gains", "saturated_gains"]

_MARGIN = 0.99
"""How far inside the conditions saturated gains are left."""


class GainCheck(NamedTuple):
    """Whether gains meet the conditions, and a sentence where they do not."""

    converges: bool
    reason: str


def check_gains(k_11: float, k_21: float, k_v: float, k_U: float) -> GainCheck:
    """Tell whether linear gains [1/s] with the model's k_v, k_U [1/s] meet (4.18) and (4.19)."""
    if not k_21 > -k_U:
        return GainCheck(False, f"k_21 = {k_21:g} is not above -k_U = {-k_U:g} 1/s: (4.19)")
    largest = 2.0 * sqrt(k_v * (k_21 + k_U))
    if not abs(k_11) < largest:
        return GainCheck(
            False, f"|k_11| = {abs(k_11):g} is not below 2 sqrt(k_v (k_21 + k_U)) = {largest:g} 1/s: (4.18)"
        )
    return GainCheck(True, "(4.18) and (4.19) hold")


@equation
def saturated_gains(k_11, k_21, k_v, k_U):  # type: ignore[no-untyped-def]
    """Return (k_11, k_21) [1/s] moved into (4.18), (4.19): k_21 first, then k_11 into what that leaves."""
    k_21 = max(k_21, -_MARGIN * k_U)
    largest = _MARGIN * 2.0 * sqrt(k_v * (k_21 + k_U))
    return (copysign(largest, k_11) if abs(k_11) > largest else k_11), k_21
