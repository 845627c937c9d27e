"""A dead zone that is wider than the parameters say (another driver, another supply), or narrower.

The edges stop at zero: a dead zone cannot be narrower than none.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def edges(edges, n, p, e):  # type: ignore[no-untyped-def]
    """Return both edges [V], moved outwards by s."""
    lower, upper = edges
    s = e.dead_zone_shift_voltage
    return np.minimum(lower - s, 0.0), np.maximum(upper + s, 0.0)


EFFECT = Effect(
    id="dead_zone_shift",
    title="shift of the edges of the dead zone",
    block="command",
    equation="delta_u1 - s, delta_u2 + s",
    parameters=(
        EffectParameter(
            name="voltage", unit="V", meaning="by which each edge moves outwards", lower=0.0, upper=0.4, both_signs=True
        ),
    ),
    note="no edge passes 0 V; a model without delta_u1 and delta_u2 has both at 0, and gets a dead zone by s > 0",
    hooks={"edges": edges},
    suspected=(Suspected(sizes={"voltage": (0.2, 0.05)}),),
)
