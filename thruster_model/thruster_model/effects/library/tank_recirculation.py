"""The wake comes back round the tank after tau and keeps the ambient flow going: dU/dt + s k_U U(t - tau).

At rest the water's decay is k_U (1 - s) instead of k_U. Before the run U is taken as zero. The delay is remembered only
where s is not zero.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def ambient(u_dot, ambient, past, force, p, e):  # type: ignore[no-untyped-def]
    """Return dU/dt with the flow that comes back."""
    return u_dot + e.tank_recirculation_share * p.k_U * past


@equation
def memory(delay, e):  # type: ignore[no-untyped-def]
    """Return how far back to remember [s]."""
    return np.maximum(delay, e.tank_recirculation_delay * (e.tank_recirculation_share != 0.0))


EFFECT = Effect(
    id="tank_recirculation",
    title="wake that comes back round the tank",
    block="flow",
    equation="dU/dt + s k_U U(t - tau)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the flow's decay made up", lower=0.0, upper=0.9),
        EffectParameter(name="delay", unit="s", meaning="tau, once round the tank", lower=1.0, upper=10.0, neutral=3.0),
    ),
    hooks={"ambient": ambient, "memory": memory},
    steady=False,
)
