"""Thrust lost while the propeller works against the flow through its duct, as after each reversal: n v < 0.

The blades then meet the water far from the angle that they are made for, and stall.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import AGAINST, SUDDEN, WITH, Effect, EffectParameter, Suspected
from thruster_model.equations.selection import selected

LONGEST = 2.5e-3  # [s], over the instant at which thrust jumps


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust times (1 - s) while n v < 0, torque as it is."""
    force, moment = loads
    told = (gate == WITH) | (gate == AGAINST)
    return force * (1.0 - e.flow_reversal_loss_share * (selected(told, gate, n * v) < 0.0)), moment


@equation
def step(step, n, n_dot, v, v_dot, e):  # type: ignore[no-untyped-def]
    """Return a step [s] that is short enough for the jump, where rotor or flow may turn."""
    turns = (np.abs(n) < SUDDEN * np.abs(n_dot) * step) | (np.abs(v) < SUDDEN * np.abs(v_dot) * step)
    return selected((e.flow_reversal_loss_share != 0.0) & turns, np.minimum(step, LONGEST), step)


EFFECT = Effect(
    id="flow_reversal_loss",
    title="loss of thrust against the flow",
    block="thrust",
    equation="T (1 - s) while n v < 0",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the thrust lost against the flow", lower=0.0, upper=0.9),
    ),
    hooks={"loads": loads, "step": step},
    search="turns",
    jumps=True,
    suspected=(Suspected(sizes={"share": (0.5, 0.2)}, flowing=True),),
)
