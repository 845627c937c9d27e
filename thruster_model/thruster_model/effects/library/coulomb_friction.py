"""Dry friction of shaft seal and bearings: it brakes at any speed alike and holds a rotor that is driven too weakly.

Near rest, |n| < s / (250 1/s), friction takes up what drives the rotor, up to s, and lets the speed die away within 4
ms: a rotor driven by less than s stands still. One steepness for all sizes is stable up to steps of 11 ms.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import SUDDEN, Effect, EffectParameter, Suspected
from thruster_model.equations.selection import selected

STEEPNESS = 250.0
LONGEST = 5e-3  # [s], half of what is stable: a rotor that stops in longer ones is 0.4 rad/s off


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt less the friction; near rest the friction takes up what drives the rotor."""
    s = e.coulomb_friction_deceleration
    holding = np.minimum(np.maximum(n_dot + STEEPNESS * n, -s), s)
    return n_dot - selected(STEEPNESS * np.abs(n) < s, holding, s * np.sign(n))


@equation
def step(step, n, n_dot, v, v_dot, e):  # type: ignore[no-untyped-def]
    """Return a step [s] that is short enough for the steepness, where the rotor may come near rest, or leave it."""
    s = e.coulomb_friction_deceleration
    moves = (n != 0.0) | (n_dot != 0.0)
    near = moves & (np.abs(n) < s / STEEPNESS + SUDDEN * (np.abs(n_dot) + s) * step)
    return selected((s != 0.0) & near, np.minimum(step, LONGEST), step)


EFFECT = Effect(
    id="coulomb_friction",
    title="dry friction of the rotor",
    block="rotor",
    equation="dn/dt - s sgn(n) (sticks at n = 0 while the drive is below s)",
    parameters=(
        EffectParameter(name="deceleration", unit="rad/s^2", meaning="by the friction", lower=0.0, upper=500.0),
    ),
    note="the drive is all of dn/dt but the friction, load included; while |n| < s/(250 1/s) the friction takes it up "
    "and n dies away within 4 ms",
    hooks={"rotor": rotor, "step": step},
    suspected=(Suspected(sizes={"deceleration": (200.0, 60.0)}),),
)
