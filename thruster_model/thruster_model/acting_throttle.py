"""The acting throttle: it follows the command within its rate limit, behind a lag where an effect brings one."""

import numpy as np

from thruster_model.compilation import equation

__all__ = ["followed", "reaching"]


@equation
def reaching(gap, slope, rate):  # type: ignore[no-untyped-def]
    """Return the time [s] in which a throttle at most at `rate` [V/s] reaches a command that is `gap` [V] away and
    moves at `slope` [V/s]; infinite: never."""
    closing = rate - np.copysign(slope, gap * slope)
    if gap == 0.0:
        return 0.0
    return abs(gap) / closing if closing > 0.0 else np.inf


@equation
def followed(u, u_commanded, slope, time, rate, lag):  # type: ignore[no-untyped-def]
    """Return the acting throttle [V] `time` [s] later, under a command [V] that moves at `slope` [V/s] from now on.

    du/dt = (u_c - u) / lag, |du/dt| <= rate; lag [s], rate [V/s]: `pipeline.lag_time`, `pipeline.ramp_limit`.
    """
    gap = u_commanded - u
    if lag <= 0.0:
        reached = reaching(gap, slope, rate)
        if time < reached:
            return u + np.copysign(rate * time, gap)
        if abs(slope) <= rate:
            return u_commanded + slope * time
        return u_commanded + slope * reached + np.copysign(rate * (time - reached), slope)
    straight = reaching(np.copysign(max(abs(gap) - rate * lag, 0.0), gap), slope, rate)
    if time <= straight:
        return u + np.copysign(rate * time, gap)
    left = gap + slope * straight - np.copysign(rate * straight, gap)
    behind = slope * lag + (left - slope * lag) * np.exp(-(time - straight) / lag)
    moved = u_commanded + slope * time - behind - u
    return u + min(max(moved, -rate * time), rate * time)
