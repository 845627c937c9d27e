"""Stamps are put on by a busy host."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def logged(signal, time, values, rng, deviation):  # type: ignore[no-untyped-def]
    """Return (stamps [s], values), stamps scattered with standard `deviation` [s] and put back in order."""
    return (time, values) if deviation == 0.0 else (np.sort(time + deviation * rng.standard_normal(time.size)), values)


EFFECT = Effect(
    id="timestamp_jitter",
    title="scatter of the stamps",
    block="log",
    equation="stamp + noise of std s",
    parameters=(
        EffectParameter(name="deviation", unit="s", meaning="standard deviation of the stamps", lower=0.0, upper=0.03),
    ),
    note="of commands and of each sensor by itself; the stamps are then sorted, while readings keep their order",
    logged=logged,
    order=3,
    search="log",
    trace="stamps",
)
