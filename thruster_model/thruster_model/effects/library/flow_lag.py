"""More water to be set in motion in the duct than the parameters say: k_v, k_Uv and k_Tv divided by (1 + s).

Every term of (4.4) or (4.2) is divided alike, so the axial flow is slower (s < 0: faster) and its rest is unchanged.
A class with a steady axial flow has nothing to slow down.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected

LEAST = 0.01


@equation
def axial(v_dot, v, ambient, force, p, e):  # type: ignore[no-untyped-def]
    """Return dv/dt / (1 + s)."""
    return v_dot * (1.0 / np.maximum(1.0 + e.flow_lag_share, LEAST))


EFFECT = Effect(
    id="flow_lag",
    title="slower axial flow",
    block="flow",
    equation="k_v/(1 + s), k_Uv/(1 + s), k_Tv/(1 + s)",
    parameters=(EffectParameter(name="share", unit="1", meaning="slower than the set says", lower=-0.5, upper=4.0),),
    hooks={"axial": axial},
    order=1,
    suspected=(Suspected(sizes={"share": (1.5, 0.3)}, flowing=True),),
)
