"""A centre of mass elsewhere than assumed: ballast, batteries, a tool stowed away."""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from rov_sim.vehicle.effects.shifts import PARAMETERS, SUSPECTED, shift
from thruster_model.equations.rigid_body import moved_mass


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with r_G moved, the inertia about the centre of mass kept."""
    s = shift(active)
    if not np.any(s):
        return c
    return c._replace(M_RB=moved_mass(c.M_RB, c.r_G, c.r_G + s), r_G=c.r_G + s)


EFFECT = VehicleEffect(
    id="cg_shift",
    title="centre of mass moved",
    block="body",
    equation="r_G + s",
    parameters=PARAMETERS,
    note="the inertia about the centre of mass is kept, that about the origin follows",
    body=body,
    suspected=(SUSPECTED,),
)
