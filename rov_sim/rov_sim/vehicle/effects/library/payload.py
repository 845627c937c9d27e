"""A tool or sample that nobody entered: a point mass that displaces no water."""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected
from thruster_model.equations.rigid_body import rigid_body_mass


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with the point mass in M_RB, weight and centre of mass."""
    m = active.size("mass")
    if m == 0.0:
        return c
    r = np.array([active.size(a) for a in "xyz"])
    weight = c.weight * (1.0 + m / c.M_RB[0, 0])
    r_G = (c.M_RB[0, 0] * c.r_G + m * r) / (c.M_RB[0, 0] + m)
    return c._replace(M_RB=c.M_RB + rigid_body_mass(m, r, np.zeros((3, 3))), weight=weight, r_G=r_G)


EFFECT = VehicleEffect(
    id="payload",
    title="payload",
    block="body",
    equation="point mass at r that displaces no water",
    parameters=(
        EffectParameter(name="mass", unit="kg", meaning="of the payload", lower=0.0, upper=5.0),
        EffectParameter(name="x", unit="m", meaning="forward of the payload", lower=-1.0, upper=1.0),
        EffectParameter(name="y", unit="m", meaning="starboard of the payload", lower=-1.0, upper=1.0),
        EffectParameter(name="z", unit="m", meaning="down of the payload", lower=-1.0, upper=1.0),
    ),
    body=body,
    suspected=(Suspected(sizes={"mass": (1.0, 0.1), "x": (0.3, 0.2), "y": (0.3, 0.2), "z": (0.3, 0.2)}, carries=True),),
)
