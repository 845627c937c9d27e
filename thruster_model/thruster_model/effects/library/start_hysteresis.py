"""A sensorless driver that needs more throttle to start the rotor than to keep it turning.

The set's edges are those of starting; while |n| > 10 rad/s both are nearer to zero by s, but never beyond it. A rotor
without inertia has no speed as a state and always starts anew.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected

TURNING = 10.0


@equation
def edges(edges, n, p, e):  # type: ignore[no-untyped-def]
    """Return both edges [V], nearer to zero by s while the rotor turns."""
    lower, upper = edges
    s = e.start_hysteresis_voltage * (np.abs(n) > TURNING)
    return np.minimum(lower + s, 0.0), np.maximum(upper - s, 0.0)


EFFECT = Effect(
    id="start_hysteresis",
    title="more throttle to start than to keep turning",
    block="rotor",
    equation="delta_u1 + s, delta_u2 - s while |n| > 10 rad/s",
    parameters=(
        EffectParameter(
            name="voltage", unit="V", meaning="by which the dead zone's edges are nearer", lower=0.0, upper=0.5
        ),
    ),
    note="the edges are those that `dead_zone_shift` leaves, none passes 0 V; in `force_table` it is x = command_scale "
    "(u - delta_u2 + s) above delta_u2 - s, and likewise below",
    hooks={"edges": edges},
    order=1,
    suspected=(Suspected(sizes={"voltage": (0.25, 0.2)}),),
)
