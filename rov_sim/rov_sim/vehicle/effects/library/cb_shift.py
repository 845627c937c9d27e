"""A centre of buoyancy elsewhere than assumed: foam moved, a housing added or flooded."""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with r_B moved."""
    return c._replace(r_B=c.r_B + np.array([active.size(a) for a in "xyz"]))


EFFECT = VehicleEffect(
    id="cb_shift",
    title="centre of buoyancy moved",
    block="body",
    equation="r_B + s",
    parameters=(
        EffectParameter(name="x", unit="m", meaning="forward of the shift", lower=-0.05, upper=0.05),
        EffectParameter(name="y", unit="m", meaning="starboard of the shift", lower=-0.05, upper=0.05),
        EffectParameter(name="z", unit="m", meaning="down of the shift", lower=-0.05, upper=0.05),
    ),
    body=body,
    suspected=(Suspected(sizes={"x": (0.02, 0.003), "y": (0.02, 0.003), "z": (0.02, 0.003)}),),
)
