"""More loss of thrust by the axial flow than the map has: T - s c_nv |n| v, beside the map's own c_nv |n| v.

Where a set has no c_nv_T, that of the thesis' HL model takes its place (Table 4.2, Tecnadyne 280: 0.4146 N s^2/m). A
class without axial flow has v = 0 at all times, so nothing is lost there.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter

REFERENCE = 0.4146


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust less s c_nv |n| v, torque as it is."""
    force, moment = loads
    c_nv = p.c_nv_T + REFERENCE * (p.c_nv_T == 0.0)
    return force - e.axial_flow_loss_share * c_nv * np.abs(n) * v, moment


EFFECT = Effect(
    id="axial_flow_loss",
    title="more loss of thrust by axial flow",
    block="thrust",
    equation="T - s c_nv |n| v",
    parameters=(EffectParameter(name="share", unit="1", meaning="of c_nv in addition", lower=0.0, upper=1.5),),
    hooks={"loads": loads},
    order=-1,
)
