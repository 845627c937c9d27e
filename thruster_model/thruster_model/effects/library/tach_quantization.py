"""A tachometer with few steps: few teeth, a coarse converter."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, step):  # type: ignore[no-untyped-def]
    """Return rotor speeds (N,) rounded to multiples of `step` [rad/s]."""
    return values if step == 0.0 else step * np.round(values / step)


EFFECT = Effect(
    id="tach_quantization",
    title="coarse steps of the tachometer",
    block="sensor",
    equation="y = s round(n / s)",
    parameters=(EffectParameter(name="step", unit="rad/s", meaning="of the reading", lower=0.0, upper=20.0),),
    samples=read,
    channel="speed",
    order=4,
)
