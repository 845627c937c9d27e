"""A propeller near the surface that draws air: thrust collapses in random stretches, while |n| > n_0.

The stretches are given from outside as gates: 0 while the propeller may draw air, else 1.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust times (1 - s) while the gate is 0 and |n| > n_0, torque as it is."""
    force, moment = loads
    share = e.ventilation_share * (1.0 - gate)
    return force * (1.0 - share * (np.abs(n) > e.ventilation_onset)), moment


EFFECT = Effect(
    id="ventilation",
    title="air drawn from the surface",
    block="thrust",
    equation="T (1 - s) while the gate is 0 and |n| > n_0",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the thrust lost in air", lower=0.0, upper=0.8),
        EffectParameter(
            name="onset", unit="rad/s", meaning="n_0, speed that draws air", lower=20.0, upper=250.0, neutral=60.0
        ),
    ),
    note="the gate is 0 in stretches of random length, in which the propeller may draw air, else 1: "
    "a simulation draws them, 1 s with air and 1.5 s without on average; a diagnosis reads them off the thrust, "
    "if a speed is there too",
    hooks={"loads": loads},
    search="gates",
    jumps=True,
)
