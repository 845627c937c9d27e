"""A velocimeter whose samples come late: averaging, serial line, another clock."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, time):  # type: ignore[no-untyped-def]
    """Return flow readings (N,) `time` [s] late; before the first one it holds."""
    at = dt * np.arange(values.size)
    return values if time == 0.0 else np.interp(at - time, at, values)


EFFECT = Effect(
    id="flow_delay",
    title="late readings of the velocimeter",
    block="sensor",
    equation="y(t) = U(t - s)",
    parameters=(EffectParameter(name="time", unit="s", meaning="by which readings are late", lower=0.0, upper=1.5),),
    samples=read,
    channel="axial ambient",
    order=1,
    twins=("log_alignment",),
)
