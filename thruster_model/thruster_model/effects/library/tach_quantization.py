"""A tachometer with few steps: few teeth, a coarse converter."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the rotor speed rounded to a multiple of s [rad/s]."""
    s = e.tach_quantization_step
    return s * np.round(x / s)


EFFECT = Effect(
    id="tach_quantization",
    title="coarse steps of the tachometer",
    block="sensor",
    equation="y = s round(n / s)",
    parameters=(EffectParameter(name="step", unit="rad/s", meaning="of the reading", lower=0.0, upper=20.0),),
    sample=sample,
    channel="speed",
    order=4,
    search="reading_lattice",
    tries=(60,),
    trace="lattice",
    entails=("tach_dropout",),
)
