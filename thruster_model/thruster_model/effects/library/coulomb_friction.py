"""Dry friction of shaft seal and bearings: it brakes at any speed alike and holds a rotor that is driven too weakly."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt less the friction; within 0.1 rad/s of rest the friction takes up what drives the rotor."""
    s = e.coulomb_friction_deceleration
    slow = n / 0.1
    return n_dot - np.minimum(np.maximum(s * slow, -s), s)


EFFECT = Effect(
    id="coulomb_friction",
    title="dry friction of the rotor",
    block="rotor",
    equation="dn/dt - s sgn(n), with sgn a line of width 0.1 rad/s through zero, so that the rotor sticks there",
    parameters=(
        EffectParameter(name="deceleration", unit="rad/s^2", meaning="by the friction", lower=0.0, upper=500.0),
    ),
    hooks={"rotor": rotor},
)
