"""The device ramps its output more slowly than it is said to."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def ramp(u_dot_max, e):  # type: ignore[no-untyped-def]
    """Return the rate limit [V/s], s where that is slower."""
    return np.minimum(u_dot_max, e.throttle_rate_limit_rate)


EFFECT = Effect(
    id="throttle_rate_limit",
    title="slow ramps of the throttle",
    block="command",
    equation="|du/dt| <= s",
    parameters=(
        EffectParameter(name="rate", unit="V/s", meaning="largest one", lower=2.0, upper=100.0, neutral=float("inf")),
    ),
    hooks={"ramp": ramp},
    suspected=(Suspected(sizes={"rate": (15.0, 10.0)}, grid=(40.0, 20.0, 10.0, 5.0, 2.5)),),
)
