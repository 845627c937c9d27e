"""A tachometer that sees nothing at low speed."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, threshold):  # type: ignore[no-untyped-def]
    """Return rotor speeds (N,), 0 where their magnitude is below `threshold` [rad/s]."""
    return np.where(np.abs(values) < threshold, 0.0, values)


EFFECT = Effect(
    id="tach_dropout",
    title="tachometer blind at low speed",
    block="sensor",
    equation="y = 0 for |n| < s",
    parameters=(
        EffectParameter(name="threshold", unit="rad/s", meaning="below which it reads 0", lower=0.0, upper=40.0),
    ),
    samples=read,
    channel="speed",
    order=4,
)
