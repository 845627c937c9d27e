"""The device cuts commands off earlier than it is said to."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def saturated(commands, dt, limit):  # type: ignore[no-untyped-def]
    """Return commands (N,) limited to +- `limit` [V]."""
    return np.clip(commands, -limit, limit)


EFFECT = Effect(
    id="throttle_saturation",
    title="limit of the throttle",
    block="command",
    equation="|u| <= s",
    parameters=(
        EffectParameter(name="limit", unit="V", meaning="of the throttle", lower=1.0, upper=5.0, neutral=float("inf")),
    ),
    samples=saturated,
    order=3,
)
