"""The acting throttle: it follows the command within its rate limit, behind a lag where an effect brings one."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.equations.dead_zone import ramp_limited

__all__ = ["followed"]


@equation
def followed(u, u_commanded, time, rate, lag):  # type: ignore[no-untyped-def]
    """Return the acting throttle [V] `time` [s] later, under a command [V] that is held.

    du/dt = (u_c - u) / lag, |du/dt| <= rate; lag [s], rate [V/s]: `pipeline.lag_time`, `pipeline.ramp_limit`.
    """
    if lag <= 0.0:
        return ramp_limited(u, u_commanded, rate, time)
    gap = u_commanded - u
    straight = max(abs(gap) / rate - lag, 0.0)
    if time <= straight:
        return u + np.copysign(rate * time, gap)
    left = gap - np.copysign(rate * straight, gap)
    return u_commanded - left * np.exp(-(time - straight) / lag)
