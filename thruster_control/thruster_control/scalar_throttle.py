"""The throttle for a demanded drive, (3.10), in the form of a branch.

`thruster_model.equations.dead_zone.dead_zone_inverse` is the same for arrays; called with scalars in a kernel, its
`np.where` makes nine arrays (570 ns), which a control step cannot afford. A test holds the two together.
"""

from thruster_model.compilation import equation

__all__ = ["throttle_for_drive"]


@equation
def throttle_for_drive(alpha, p):  # type: ignore[no-untyped-def]
    """Return gamma^-1(alpha) [V] for alpha [rad/s^2], both scalars; `p` = ThrusterCoefficients."""
    if alpha < 0.0:
        return alpha / p.c_u1 + p.delta_u1
    if alpha > 0.0:
        return alpha / p.c_u2 + p.delta_u2
    return alpha
