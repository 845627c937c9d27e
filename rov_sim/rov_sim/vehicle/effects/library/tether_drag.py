"""The cable: at its anchor it pulls against the motion through the water.

f = -1/2 rho C_d d s |v_t| v_t, v_t: velocity of the anchor through the water, d = 8 mm, C_d = 1.2. Twice on one
vehicle the last one holds.
"""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected

DIAMETER, C_D = 0.008, 1.2  # m, 1


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with a cable of that length at that anchor."""
    s = active.size("length")
    if s == 0.0:
        return c
    drag = 0.5 * c.density * C_D * DIAMETER * s
    return c._replace(tether=np.array([drag, *(active.size(a) for a in "xyz")]))


EFFECT = VehicleEffect(
    id="tether_drag",
    title="drag of the tether",
    block="body",
    equation=f"-1/2 density C_d d length |v_t| v_t, C_d = {C_D}, d = {DIAMETER} m, v_t: anchor through water",
    parameters=(
        EffectParameter(
            name="length",
            unit="m",
            meaning="of the cable that is drawn along, from the anchor on the vehicle",
            lower=0.0,
            upper=100.0,
        ),
        EffectParameter(name="x", unit="m", meaning="forward of the anchor", lower=-1.0, upper=1.0),
        EffectParameter(name="y", unit="m", meaning="starboard of the anchor", lower=-1.0, upper=1.0),
        EffectParameter(name="z", unit="m", meaning="down of the anchor", lower=-1.0, upper=1.0),
    ),
    order=1,
    body=body,
    suspected=(
        Suspected(sizes={"length": (30.0, 5.0), "x": (0.3, 0.2), "y": (0.3, 0.2), "z": (0.3, 0.2)}, carries=True),
    ),
)
