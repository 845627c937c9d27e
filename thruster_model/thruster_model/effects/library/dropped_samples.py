"""Samples are lost and the last value is logged again."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def logged(signal, time, values, rng, share):  # type: ignore[no-untyped-def]
    """Return (stamps [s], values), a `share` of the values repeating the one before."""
    if share == 0.0:
        return time, values
    kept = rng.random(values.size) >= share
    kept[0] = True
    return time, values[np.maximum.accumulate(np.where(kept, np.arange(values.size), 0))]


EFFECT = Effect(
    id="dropped_samples",
    title="lost samples",
    block="log",
    equation="a share s of samples repeats the last one",
    parameters=(EffectParameter(name="share", unit="1", meaning="of samples lost", lower=0.0, upper=0.5),),
    note="of each sensor by itself; commands are all logged",
    logged=logged,
    channel="speed axial ambient thrust torque",
    order=4,
    search="log",
    trace="repeats",
)
