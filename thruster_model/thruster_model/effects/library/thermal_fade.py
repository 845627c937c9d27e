"""A motor or driver that weakens as it warms up: dh/dt = (|u|/u_max - h)/tau, gamma (1 - s h), u_max = 5 V.

The heat h is 0 when cold and 1 after a long time at full throttle. It is integrated exactly for a throttle that is
constant over the step: h(t + dt) = g + (h(t) - g) exp(-dt/tau), g = |u|/u_max. The time constant alone does nothing.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected

U_MAX = 5.0
SHORTEST = 1e-3


@equation
def drive(drive, n, heat, supply, p, e):  # type: ignore[no-untyped-def]
    """Return gamma(u) (1 - s h)."""
    return drive * (1.0 - e.thermal_fade_share * heat)


@equation
def heat(heat, u, dt, p, e):  # type: ignore[no-untyped-def]
    """Return the heat after `dt` [s] at the throttle u [V]."""
    settled = np.abs(u) * (1.0 / U_MAX)
    return settled + (heat - settled) * np.exp(-dt / np.maximum(e.thermal_fade_time_constant, SHORTEST))


EFFECT = Effect(
    id="thermal_fade",
    title="fading of a warm motor",
    block="command",
    equation="dh/dt = (|u|/u_max - h)/tau, gamma (1 - s h)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the drive lost when hot", lower=0.0, upper=0.5),
        EffectParameter(name="time_constant", unit="s", meaning="of warming up", lower=5.0, upper=200.0, neutral=60.0),
    ),
    note="u_max is 5 V; the motor is cold, h = 0, at the start of a run",
    hooks={"drive": drive, "heat": heat},
    steady=False,
    suspected=tuple(
        Suspected(sizes={"share": (0.3, 0.1), "time_constant": (0.3 * tau, 0.1 * tau)}, about={"time_constant": tau})
        for tau in (30.0, 12.0, 75.0)
    ),
)
