"""Growth or line around the propeller: less thrust for more torque.

Where the water's torque is k_2 n|n| in the rotor's equation (3.7), that grows instead of Q, which does not act there.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust times (1 - s), torque times (1 + s)."""
    force, moment = loads
    s = e.propeller_fouling_share
    return force * (1.0 - s), moment * (1.0 + s)


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt with k_2 (1 + s)."""
    return n_dot - e.propeller_fouling_share * p.k_2 * n * np.abs(n)


EFFECT = Effect(
    id="propeller_fouling",
    title="fouling of the propeller",
    block="rotor",
    equation="T (1 - s), Q (1 + s)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of thrust lost and of torque gained", lower=0.0, upper=0.6),
    ),
    note="where the rotor's equation has k_2 n|n| in place of k_Q Q, it has k_2 (1 + s) n|n|",
    hooks={"loads": loads, "rotor": rotor},
    suspected=(Suspected(sizes={"share": (0.3, 0.1)}),),
)
