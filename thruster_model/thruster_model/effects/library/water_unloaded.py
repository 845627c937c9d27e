"""A propeller partly out of the water: the share s of its disc meets none; s = 1 is a thruster in air.

Thrust, also that of entrained water, and the water's part of the rotor's torque vanish by that share: k_Q Q, or
k_2 n|n| where (3.7) has it in the rotor's equation. Friction k_n n stays.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust as it is, torque times (1 - s)."""
    force, moment = loads
    return force, moment * (1.0 - e.water_unloaded_share)


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt with k_2 (1 - s)."""
    return n_dot + e.water_unloaded_share * p.k_2 * n * np.abs(n)


@equation
def thrust_dynamics(force, n_dot, p, e):  # type: ignore[no-untyped-def]
    """Return thrust times (1 - s), after all that adds to it."""
    return force * (1.0 - e.water_unloaded_share)


EFFECT = Effect(
    id="water_unloaded",
    title="propeller out of the water",
    block="thrust",
    equation="T (1 - s), Q (1 - s)",
    parameters=(EffectParameter(name="share", unit="1", meaning="of the propeller in air", lower=0.0, upper=1.0),),
    note="where the rotor's equation has k_2 n|n| in place of k_Q Q, it has k_2 (1 - s) n|n|",
    hooks={"loads": loads, "rotor": rotor, "thrust_dynamics": thrust_dynamics},
    order=1,
)
