"""A loss of thrust with the square of the axial flow, which HQ knows as c_v and HL does not: drag of duct and hub."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust less s v|v|, torque as it is."""
    force, moment = loads
    return force - e.quadratic_flow_loss_coefficient * v * np.abs(v), moment


EFFECT = Effect(
    id="quadratic_flow_loss",
    title="loss of thrust by the square of axial flow",
    block="thrust",
    equation="T - s v|v|",
    parameters=(
        EffectParameter(name="coefficient", unit="N s^2/m^2", meaning="of v|v| in addition", lower=0.0, upper=400.0),
    ),
    hooks={"loads": loads},
    order=-1,
    suspected=(Suspected(sizes={"coefficient": (200.0, 40.0)}, flowing=True),),
)
