"""The structure between thruster and load cell is springy: it rings along the thrust after jumps."""

from functools import lru_cache

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, frequency, damping):  # type: ignore[no-untyped-def]
    """Return readings (N,) of a mode at `frequency` [Hz] with `damping` of the critical one; from rest.

    Exact for a load that goes in straight lines from sample to sample (first-order hold).
    """
    from scipy.signal import lfilter  # a quarter of a second to import

    if frequency == float("inf"):
        return values
    return lfilter(*_filter(float(frequency), float(damping), float(dt)), values)


@lru_cache(maxsize=64)
def _filter(frequency: float, damping: float, dt: float):  # type: ignore[no-untyped-def]
    from scipy.signal import cont2discrete

    omega = 2.0 * np.pi * frequency
    mode = ([omega**2], [1.0, 2.0 * damping * omega, omega**2])
    numerator, denominator, _ = cont2discrete(mode, dt, method="foh")
    return numerator.ravel(), denominator


EFFECT = Effect(
    id="load_cell_resonance",
    title="resonance of the load cell",
    block="sensor",
    equation="d2y/dt2 + 2 zeta w dy/dt + w^2 y = w^2 T, w = 2 pi f",
    parameters=(
        EffectParameter(
            name="frequency", unit="Hz", meaning="of the mode", lower=1.0, upper=30.0, neutral=float("inf")
        ),
        EffectParameter(
            name="damping", unit="1", meaning="share of the critical damping", lower=0.005, upper=1.0, neutral=0.05
        ),
    ),
    samples=read,
    channel="thrust",
    order=1,
)
