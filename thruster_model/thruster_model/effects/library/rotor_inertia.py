"""A rotor heavier than the parameters say (another propeller, entrained water turning with it), or lighter.

All torques then turn it more slowly, those of other effects as well; rest states stay.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected

LEAST = 0.01


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt / (1 + s)."""
    return n_dot * (1.0 / np.maximum(1.0 + e.rotor_inertia_share, LEAST))


EFFECT = Effect(
    id="rotor_inertia",
    title="inertia of the rotor",
    block="rotor",
    equation="dn/dt / (1 + s)",
    parameters=(EffectParameter(name="share", unit="1", meaning="of the inertia in addition", lower=-0.5, upper=1.5),),
    hooks={"rotor": rotor},
    order=2,
    suspected=(Suspected(sizes={"share": (0.6, 0.1)}),),
)
