"""A driver that brakes the rotor where it should let it coast (or the reverse): k_n (1 + s) while |n| falls.

Whether |n| falls is decided without this effect, a = -n dn/dt / |n| > 0, and the additional deceleration is
s min(a, k_n |n|): all of s k_n |n| once the rotor slows by k_n |n| or more, as any rotor does with the drive off, and
less on gentler ways down. So it is continuous at a = 0, and braking alone never reverses the sign of dn/dt for s > -1.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt with k_n (1 + s) while |n| falls."""
    friction = p.k_n * n
    falling = np.minimum(np.maximum(-n_dot, np.minimum(friction, 0.0)), np.maximum(friction, 0.0))
    return n_dot - e.brake_asymmetry_share * falling


EFFECT = Effect(
    id="brake_asymmetry",
    title="braking unlike acceleration",
    block="rotor",
    equation="k_n (1 + s) while |n| falls",
    parameters=(
        EffectParameter(
            name="share", unit="1", meaning="of k_n in addition while braking", lower=0.0, upper=0.8, both_signs=True
        ),
    ),
    hooks={"rotor": rotor},
    order=1,
)
