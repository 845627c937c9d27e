"""A tachometer behind a smoothing filter."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, time):  # type: ignore[no-untyped-def]
    """Return rotor speeds (N,) `dt` [s] apart behind a first-order lag of `time` [s]; exact for lines between them."""
    from scipy.signal import lfilter  # a quarter of a second to import

    if time == 0.0:
        return values
    keep = np.exp(-dt / time)
    ahead = 1.0 - (1.0 - keep) * time / dt
    settled = np.array([values[0] * (1.0 - ahead)])
    return lfilter([ahead, 1.0 - keep - ahead], [1.0, -keep], values, zi=settled)[0]


EFFECT = Effect(
    id="tach_lag",
    title="lag of the tachometer",
    block="sensor",
    equation="dy/dt = (n - y) / s",
    parameters=(EffectParameter(name="time", unit="s", meaning="constant of the lag", lower=0.0, upper=0.4),),
    samples=read,
    channel="speed",
    order=1,
)
