"""What effects share that move a centre of the body: its shift and how a diagnosis suspects it."""

import numpy as np

from thruster_model.effects.effect import EffectParameter, Suspected

__all__ = ["PARAMETERS", "SUSPECTED", "shift"]

PARAMETERS = (
    EffectParameter(name="x", unit="m", meaning="forward of the shift", lower=-0.05, upper=0.05),
    EffectParameter(name="y", unit="m", meaning="starboard of the shift", lower=-0.05, upper=0.05),
    EffectParameter(name="z", unit="m", meaning="down of the shift", lower=-0.05, upper=0.05),
)
SUSPECTED = Suspected(sizes={"x": (0.02, 0.003), "y": (0.02, 0.003), "z": (0.02, 0.003)})


def shift(active):  # type: ignore[no-untyped-def]
    """Return the shift (3,) [m] of an effect that is on, body axes."""
    return np.array([active.size(p.name) for p in PARAMETERS])
