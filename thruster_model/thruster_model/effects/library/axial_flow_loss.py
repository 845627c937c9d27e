"""More loss of thrust by the axial flow than the map has: T - s c_nv |n| v, beside the map's own c_nv |n| v.

Where a set has no c_nv_T, that of the thesis' HL model takes its place (Table 4.2, Tecnadyne 280: 0.4146 N s^2/m), and
where it has no flow at all (the simplified model) the flow of that HL model comes with the effect: (4.4) and (4.5) with
the coefficients of Table 4.1. A class with a steady axial flow keeps its own.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected

REFERENCE = 0.4146


# Table 4.1, HL: k_v, k_Uv, k_w, k_Tv, k_U, k_UU, k_TU.
K_V, K_UV, K_W, K_TV = 1.102, 67.37, 0.89, 0.01232
K_U, K_UU, K_TU = 0.2396, 1.258, 0.004855


@equation
def axial(v_dot, v, ambient, force, p, e):  # type: ignore[no-untyped-def]
    """Return dv/dt, that of the HL model where the set has no flow of its own."""
    own = (p.k_Tv == 0.0) & (p.k_v == 0.0) & (e.axial_flow_loss_share != 0.0)
    return v_dot + own * (-K_V * v - K_UV * np.abs(v) * (v - K_W * ambient) + K_TV * force)


@equation
def ambient(u_dot, ambient, past, force, p, e):  # type: ignore[no-untyped-def]
    """Return dU/dt, that of the HL model where the set has no flow of its own."""
    own = (p.k_TU == 0.0) & (p.k_U == 0.0) & (e.axial_flow_loss_share != 0.0)
    return u_dot + own * (-K_U * ambient - K_UU * ambient * np.abs(ambient) + K_TU * force)


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
    note="where a set has no c_nv it is the HL model's; where it has no flow, v and U follow (4.4) and (4.5) with the "
    "HL model's numbers",
    hooks={"loads": loads, "axial": axial, "ambient": ambient},
    order=-1,
    suspected=(Suspected(sizes={"share": (0.7, 0.2)}, flowing=True),),
)
