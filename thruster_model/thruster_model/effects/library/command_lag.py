"""A first-order lag between command and motor: a filter in the driver, which may be slower one way than the other.

The acting throttle u itself follows, exactly for a command that is held, and never faster than its rate limit. Drivers
speed a motor up at another rate than that at which they let it slow down; which of the two holds is decided as a step
begins.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected
from thruster_model.equations.selection import selected


@equation
def lag(lag, u, command, e):  # type: ignore[no-untyped-def]
    """Return the time constant [s]."""
    uneven = e.command_lag_unevenness
    return lag + e.command_lag_time * (1.0 + selected(np.abs(command) > np.abs(u), uneven, -uneven))


EFFECT = Effect(
    id="command_lag",
    title="lag of the command",
    block="command",
    equation="du/dt = (u_c - u) / s; s (1 + a) while |u_c| > |u|, else s (1 - a)",
    parameters=(
        EffectParameter(name="time", unit="s", meaning="constant of the lag", lower=0.0, upper=0.4),
        EffectParameter(
            name="unevenness",
            unit="1",
            meaning="a, how much longer it is while |u| rises",
            lower=0.0,
            upper=0.5,
            both_signs=True,
        ),
    ),
    hooks={"lag": lag},
    tries=(0, 1),
    suspected=(Suspected(sizes={"time": (0.15, 0.03), "unevenness": (0.1, 0.05)}),),
)
