"""The acting throttle: it follows the command within its rate limit, behind a lag where an effect brings one."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.equations.dead_zone import ramp_limited
from thruster_model.pipeline import lag_time, ramp_limit

__all__ = ["followed", "throttle_after"]


@equation
def throttle_after(u, u_commanded, time, p, e):  # type: ignore[no-untyped-def]
    """Return the acting throttle [V] `time` [s] later, under a command [V] that is held."""
    return followed(u, u_commanded, time, ramp_limit(p.u_dot_max, e), lag_time(0.0, e))


@equation
def followed(u, u_commanded, time, rate, lag):  # type: ignore[no-untyped-def]
    """Return it for a rate limit [V/s] and a lag [s]: du/dt = (u_c - u) / lag, |du/dt| <= rate."""
    if lag <= 0.0:
        return ramp_limited(u, u_commanded, rate, time)
    gap = u_commanded - u
    straight = max(abs(gap) / rate - lag, 0.0)
    if time <= straight:
        return u + np.copysign(rate * time, gap)
    left = gap - np.copysign(rate * straight, gap)
    return u_commanded - left * np.exp(-(time - straight) / lag)
