"""A centre of mass elsewhere than assumed: ballast, batteries, a tool stowed away."""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected
from thruster_model.equations.rigid_body import moved_mass


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with r_G moved, the inertia about the centre of mass kept."""
    s = np.array([active.size(a) for a in "xyz"])
    if not np.any(s):
        return c
    return c._replace(M_RB=moved_mass(c.M_RB, c.r_G, c.r_G + s), r_G=c.r_G + s)


EFFECT = VehicleEffect(
    id="cg_shift",
    title="centre of mass moved",
    block="body",
    equation="r_G + s",
    parameters=(
        EffectParameter(name="x", unit="m", meaning="forward of the shift", lower=-0.05, upper=0.05),
        EffectParameter(name="y", unit="m", meaning="starboard of the shift", lower=-0.05, upper=0.05),
        EffectParameter(name="z", unit="m", meaning="down of the shift", lower=-0.05, upper=0.05),
    ),
    body=body,
    suspected=(Suspected(sizes={"x": (0.02, 0.003), "y": (0.02, 0.003), "z": (0.02, 0.003)}),),
)
