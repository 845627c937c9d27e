"""Ram drag: the water that thrusters take in from the side has to be turned into their axes.

By momentum theory a thrust T draws a mass flow of sqrt(rho A |T| / 2) through a disc of area A. Its velocity across the
axis is lost, as is known of tunnel thrusters and ducted fans in a cross-flow.
"""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with discs of that diameter."""
    return c._replace(ram=active.size("diameter") * float(np.sqrt(np.pi * c.density / 8.0)))


EFFECT = VehicleEffect(
    id="ram_drag",
    title="drag of the water that thrusters take in",
    block="thrusters",
    equation="-diameter sqrt(pi density |T_i| / 8) v_i across the axis, v_i: thruster i through the water",
    parameters=(
        EffectParameter(
            name="diameter",
            unit="m",
            meaning="of the disc through which each thruster draws water",
            lower=0.0,
            upper=0.3,
        ),
    ),
    note="of all thrusters, each at its place",
    order=1,
    body=body,
    suspected=(Suspected(sizes={"diameter": (0.06, 0.01)}),),
)
