"""Spikes of an acoustic velocimeter: bubbles, too few echoes, velocities that wrap."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, share):  # type: ignore[no-untyped-def]
    """Return flow readings (N,), a `share` of them with spikes of 0.3 m/s standard deviation; none without `rng`."""
    if rng is None or share == 0.0:
        return values
    hit = rng.random(values.size) < share
    return values + np.where(hit, 0.3 * rng.standard_normal(values.size), 0.0)


EFFECT = Effect(
    id="flow_spikes",
    title="spikes of the velocimeter",
    block="sensor",
    equation="y + spikes of std 0.3 m/s in a share s of the samples",
    parameters=(EffectParameter(name="share", unit="1", meaning="of samples with a spike", lower=0.0, upper=0.3),),
    samples=read,
    channel="axial ambient",
    order=5,
)
