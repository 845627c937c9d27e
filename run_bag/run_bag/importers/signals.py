"""What can be read off a tachometer signal: rest, glitches, rotation, sign. Arrays in, arrays out."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, uniform_filter1d

Array = NDArray[np.float64]
LEAST_HOLD = 0.15  # [s] a throttle of the other sign for less turns nothing round
REVERSAL = 0.25  # [s] in which the rotor passes zero
MEDIAN_WINDOW = 0.5  # [s] longer than twice any glitch seen, shorter than any ramp
SMOOTH_WINDOW = 0.05  # [s]
RISEN = 4.0  # standard deviations by which a magnitude must have left its least for a rotor to turn for sure
SIGN_WINDOW = 0.02  # [s] less than the sample period of a controller: its samples stay as they are
REST_MARGIN = 0.2  # [s]
LEAST_REST = 0.3  # [s]
LEAST_GLITCH = 20.0  # [rad/s] above the running median


@dataclass(frozen=True)
class Glitch:
    """A short peak that no rotor can follow: time of its top [s], height [rad/s], duration [s]."""

    time: float
    height: float
    duration: float


def period(time: Array) -> float:
    """Return the median sample period [s]."""
    return float(np.median(np.diff(time)))


def smooth(values: Array, time: Array, window: float) -> Array:
    """Return the running mean over a window [s], without delay."""
    size = max(1, round(window / period(time)))
    return np.asarray(uniform_filter1d(values, size, axis=0, mode="nearest"), dtype=np.float64)


def running_median(values: Array, time: Array, window: float = MEDIAN_WINDOW) -> Array:
    """Return the running median over a window [s], from every tenth of it (a glitch leaves no trace)."""
    step = max(1, round(window / 50 / period(time)))
    coarse = smooth(values, time, window / 50)[::step]
    filtered = median_filter(coarse, size=max(3, round(window / period(time) / step)), mode="nearest")
    return np.interp(time, time[::step], filtered)


def rest_window(time: Array, speed: Array) -> tuple[float, float] | None:
    """Return the stretch from the start to a little before the tachometer leaves its rest [s], None if short.

    Rest is the median of the first 0.3 s; the scatter that a departure is compared with is that of its
    running mean.
    """
    first = time <= time[0] + LEAST_REST
    calm = smooth(speed, time, SMOOTH_WINDOW)
    level = float(np.median(speed[first]))
    scatter = 1.4826 * float(np.median(np.abs(speed[first] - level)))
    left = np.flatnonzero(np.abs(calm - level) > max(2 * scatter, 1.0))
    end = float(time[left[0]] - REST_MARGIN) if left.size else float(time[-1])
    return (float(time[0]), end) if end - time[0] >= LEAST_REST else None


def glitches(time: Array, speed: Array) -> list[Glitch]:
    """Return the short peaks of |n| [rad/s] above the running median."""
    fine = smooth(np.abs(speed), time, 0.005)
    excess = fine - running_median(np.abs(speed), time)
    noise = 1.4826 * float(np.median(np.abs(excess)))
    high = excess > max(8 * noise, LEAST_GLITCH)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], high.astype(np.int8), [0]])))
    found: list[Glitch] = []
    for begin, end in edges.reshape(-1, 2):
        duration = float(time[min(end, len(time)) - 1] - time[begin])
        top = begin + int(np.argmax(excess[begin:end]))
        if found and time[begin] - found[-1].time < MEDIAN_WINDOW / 2:
            if fine[top] > found[-1].height:
                found[-1] = Glitch(float(time[top]), float(fine[top]), found[-1].duration + duration)
        elif duration <= MEDIAN_WINDOW / 2:
            found.append(Glitch(float(time[top]), float(fine[top]), duration))
    return found


def takes_both_signs(time: Array, values: Array, least: float) -> bool:
    """Say whether a signal stays beyond +least and beyond -least for longer than the median window each."""
    calm = running_median(values, time)
    return bool(np.max(calm) > least and np.min(calm) < -least)


def infer_sign(time: Array, speed: Array, throttle: Array, edge: float = 0.0) -> Array:
    """Return the sign of the rotation, +1 or -1 (N,): the throttle's, switching at the least |n| after it.

    The least |n| is looked for from where the throttle changes its sign until 0.25 s after it has left the dead zone,
    of which `edge` [V] is the farther edge: within it nothing turns the rotor round. How small it is does not
    matter, for a tachometer with a filter need not come near zero in a fast reversal. A throttle that
    changes back within 0.15 s turns nothing round. Without any throttle the sign is positive.
    """
    asked = np.sign(throttle)
    moving = np.flatnonzero(asked)
    if not moving.size:
        return np.ones_like(speed)
    filled = asked[moving[np.maximum(np.searchsorted(moving, np.arange(len(asked)), side="right") - 1, 0)]]
    magnitude = smooth(np.abs(speed), time, SIGN_WINDOW)
    changes = [*np.flatnonzero(np.diff(filled)) + 1, len(filled)]
    result, current, switched = np.empty_like(speed), float(filled[0]), 0
    for change, following in pairwise(changes):
        held = time[following - 1] - time[change]
        if filled[change] == current or held < LEAST_HOLD:
            continue
        driven = change + np.flatnonzero(np.abs(throttle[change:following]) > edge)
        if not driven.size:
            continue
        last = min(following, int(np.searchsorted(time, time[driven[0]] + REVERSAL)) + 1)
        lowest = change + int(np.argmin(magnitude[change:last]))
        result[switched:lowest] = current
        current, switched = float(filled[change]), lowest
    result[switched:] = current
    return result


def sign_unknown(time: Array, speed: Array, throttle: Array, sign: Array, edge: float = 0.0) -> NDArray[np.bool_]:
    """Return about which samples nothing tells which way the rotor turns, (N,): those of its reversals.

    A reversal lasts from where the magnitude is as small as it gets, within its noise, until the throttle has left the
    dead zone and the magnitude has risen again; one that the recording's end cuts off may have happened or not.

    Args:
        time: [s], (N,).
        speed: magnitudes [rad/s], (N,).
        throttle: [V], (N,).
        sign: as `infer_sign` returns it, (N,).
        edge: the farther edge of the dead zone [V].
    """
    magnitude = smooth(np.abs(speed), time, SIGN_WINDOW)
    rise = RISEN * float(np.median(np.abs(np.diff(speed, 3)))) / (0.6745 * np.sqrt(20.0))
    unknown = (time > time[-1] - REVERSAL) & (np.sign(throttle) * sign < 0.0)
    turned = [0, *(int(k) + 1 for k in np.flatnonzero(np.diff(sign))), len(sign)]
    for before, lowest, after in zip(turned[:-2], turned[1:-1], turned[2:], strict=True):
        fallen = np.flatnonzero(magnitude[before:lowest] > magnitude[lowest] + rise)
        first = before + int(fallen[-1]) + 1 if fallen.size else before
        driven = lowest + np.flatnonzero((sign[lowest] * throttle > edge)[lowest:after])
        own = magnitude[driven[0] if driven.size else after : after]
        risen = np.flatnonzero(own > np.minimum.accumulate(own) + rise) + after - own.size
        unknown[min(first, lowest - 1) : risen[0] if risen.size else after] = True
    return unknown
