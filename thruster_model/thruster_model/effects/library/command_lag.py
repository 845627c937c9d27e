"""A first-order lag between command and motor: a filter in the driver.

The acting throttle u itself follows, exactly for a command that is held, and never faster than its rate limit.
"""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def lag(lag, e):  # type: ignore[no-untyped-def]
    """Return the time constant [s]."""
    return lag + e.command_lag_time


EFFECT = Effect(
    id="command_lag",
    title="lag of the command",
    block="command",
    equation="du/dt = (u_c - u) / s",
    parameters=(EffectParameter(name="time", unit="s", meaning="constant of the lag", lower=0.0, upper=0.4),),
    hooks={"lag": lag},
    suspected=(Suspected(sizes={"time": (0.15, 0.03)}),),
)
