"""The direction of a rotor whose tachometer tells none: that of the throttle, where it tells one."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from run_bag.importers.signals import REVERSAL, infer_sign
from thruster_model.identification.preparation import noise_level

__all__ = ["NEAR_REST", "held", "lacks_sign", "on_lines", "signed_speed", "unsigned", "with_known_sign"]

Array = NDArray[np.float64]
_SIGN_UNKNOWN, _SIGN_INFERRED = 0, 2  # thruster_msgs/msg/ThrusterState.SIGN_*
NEAR_REST = 3.0
"""Standard deviations below which a magnitude is that of its noise."""
_TURNING = 0.01  # [s] to either side of a reversal
_RISEN = 4.0  # standard deviations
_BELOW_ZERO = 5.0  # standard deviations


def lacks_sign(sources: Array, n: Array) -> bool:
    """Tell from a run's sign sources whether speeds are magnitudes.

    A source that was never set says "unknown" too: speeds below zero, by more than noise at rest, tell otherwise.
    """
    noise = float(np.nan_to_num(noise_level(n)))
    return bool(np.any(sources == _SIGN_UNKNOWN)) and not np.any(n < -_BELOW_ZERO * noise)


def unsigned(sources: Array, n: Array) -> bool:
    """Tell whether the tachometer has no sign; the speeds may have been given one since."""
    return lacks_sign(sources, n) or bool(np.any(sources == _SIGN_INFERRED))


def with_known_sign(sources: Array, n: Array) -> Array:
    """Return speeds [rad/s], (N,), NaN where single ones have no sign, as about a reversal, and are not near rest.

    Sources (N,) that are all unknown, or none at all, were never set: then the speeds have the signs that they have.
    """
    if not np.any(sources != _SIGN_UNKNOWN):
        return n
    return np.where((sources == _SIGN_UNKNOWN) & (np.abs(n) > NEAR_REST * np.nan_to_num(noise_level(n))), np.nan, n)


def signed_speed(time: Array, magnitude: Array, throttle: tuple[Array, Array]) -> Array:
    """Return magnitudes of the speed [rad/s] with the sign inferred from the throttle (stamps [s], commands [V]), (N,).

    NaN from an instant of reversal on until the magnitude rises again: which side of zero the samples nearest to it lie
    on nothing tells, nor whether a throttle within the dead zone turns the rotor round at all.
    """
    asked = held(*throttle, time)
    sign = infer_sign(time, np.nan_to_num(magnitude), asked)
    # A reversal that the recording's end cuts off may have happened or not.
    unknown = (time > time[-1] - REVERSAL) & (asked * sign < 0.0)
    rise = _RISEN * np.nan_to_num(noise_level(magnitude))
    for turned, following in pairwise([*np.flatnonzero(np.diff(sign)), time.size]):
        after = np.nan_to_num(magnitude[turned:following], nan=np.inf)
        risen = np.flatnonzero(after > np.minimum.accumulate(after) + rise)
        first = turned + (risen[0] if risen.size else after.size)
        unknown[max(turned - 1, 0) : max(first, turned + 3)] = True
        unknown |= np.abs(time - time[turned]) < _TURNING
    return np.where(unknown, np.nan, magnitude * sign)


def on_lines(time: Array, values: Array, grid: Array) -> Array:
    """Return a channel on the grid, on straight lines between samples; zero before its first finite one."""
    known = np.isfinite(values)
    return np.interp(grid, time[known], values[known], left=0.0) if np.any(known) else np.zeros(grid.shape)


def held(time: Array, values: Array, grid: Array) -> Array:
    """Return the zero-order hold of a channel on the grid; zero before its first finite sample."""
    known = np.isfinite(values)
    time, values = time[known], values[known]
    index = np.searchsorted(time, grid + 1e-9, side="right") - 1
    return np.where(index >= 0, values[np.maximum(index, 0)], 0.0)
