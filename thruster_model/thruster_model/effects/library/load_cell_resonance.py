"""The structure between thruster and load cell is springy: it rings after jumps."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, frequency, damping):  # type: ignore[no-untyped-def]
    """Return readings (N,) of a mode at `frequency` [Hz] with `damping` of the critical one; from rest."""
    from scipy.signal import cont2discrete, lfilter  # a quarter of a second to import

    if frequency == float("inf"):
        return values
    omega = 2.0 * np.pi * frequency
    mode = ([omega**2], [1.0, 2.0 * damping * omega, omega**2])
    numerator, denominator, _ = cont2discrete(mode, dt, method="bilinear")
    return lfilter(numerator.ravel(), denominator, values)


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
    channel="thrust torque",
    order=1,
)
