"""Vapour at the blades: above a speed n_0 thrust falls behind the square of the speed.

T (1 - s max(0, |n| - n_0)/n_0); what is left of T is never below zero.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected

LEAST_ONSET = 1e-3


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust less what cavitation takes, torque as it is."""
    force, moment = loads
    onset = e.cavitation_onset
    share = e.cavitation_share * (1.0 / np.maximum(onset, LEAST_ONSET))
    return force * np.maximum(1.0 - share * np.maximum(np.abs(n) - onset, 0.0), 0.0), moment


EFFECT = Effect(
    id="cavitation",
    title="cavitation at high speed",
    block="thrust",
    equation="T (1 - s max(0, |n| - n_0)/n_0)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the thrust lost at 2 n_0", lower=0.0, upper=1.0),
        EffectParameter(
            name="onset", unit="rad/s", meaning="n_0, where it begins", lower=40.0, upper=250.0, neutral=100.0
        ),
    ),
    note="what is left of T is never below 0",
    hooks={"loads": loads},
    suspected=tuple(
        Suspected(sizes={"share": (0.5, 0.1), "onset": (0.15 * onset, 0.05 * onset)}, about={"onset": onset})
        for onset in (100.0, 50.0, 70.0, 140.0, 200.0)
    ),
)
