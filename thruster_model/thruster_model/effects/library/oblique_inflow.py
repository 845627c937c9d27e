"""Ambient flow at an angle s to the thruster's axis: only its axial part U cos(s) reaches the propeller.

After Kim and Chung (`equations.inflow`): the loss of thrust by a current shrinks with cos(s) and vanishes across the
axis. What the instrument measures stays U, and so does the flow in the tank. A set with its own inflow angle a has
U cos(a) cos(s): two turns about axes across each other. A set without axial flow meets no current at all.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def approach(water, p, e):  # type: ignore[no-untyped-def]
    """Return the axial part of the ambient flow."""
    return water * np.cos(e.oblique_inflow_angle)


EFFECT = Effect(
    id="oblique_inflow",
    title="ambient flow at an angle",
    block="thrust",
    equation="U cos(s) in place of U for the propeller, not for the instrument",
    parameters=(EffectParameter(name="angle", unit="rad", meaning="of the flow to the axis", lower=0.0, upper=1.2),),
    note="the equations of v, T and Q have U cos(s), with the current of `ambient_current` in U; (4.5) has U. In "
    "`kim_chung` cosines multiply: U cos(s) cos(inflow_angle)",
    hooks={"approach": approach},
)
