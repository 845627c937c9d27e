"""A load cell that creeps or warms up."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, rate):  # type: ignore[no-untyped-def]
    """Return thrust readings (N,) that wander off at `rate` [N/s] from the start of the run."""
    return values + rate * dt * np.arange(values.size)


EFFECT = Effect(
    id="load_cell_drift",
    title="drift of the load cell",
    block="sensor",
    equation="y + s t",
    parameters=(
        EffectParameter(name="rate", unit="N/s", meaning="of the reading", lower=0.0, upper=0.1, both_signs=True),
    ),
    samples=read,
    channel="thrust",
    order=3,
)
