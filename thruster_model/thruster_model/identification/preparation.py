"""From raw samples to cell means that a fit can use: rest window, tare, masks and noise, from the data alone."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label, median_filter

from thruster_model.identification.uncertainty import autocorrelation_time

__all__ = [
    "Tared",
    "cell_means",
    "glitch_mask",
    "noise_level",
    "rest_window",
    "ringing_mask",
    "tare",
    "tare_unsigned_speed",
]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_FEWEST = 10
"""Differences that tell a noise."""


def rest_window(time: Array, throttle: Array, *, margin: float = 0.25) -> tuple[float, float]:
    """Return (start, end) [s] of the stretch before the first non-zero throttle [V], shortened by `margin` [s].

    Both ends are equal where the recording starts with a throttle: there is no rest to tare on.
    """
    moving = np.flatnonzero(throttle != 0.0)
    end = time[moving[0]] if moving.size else time[-1]
    return float(time[0]), float(max(time[0], end - margin))


class Tared(NamedTuple):
    """Values less their rest value, that value, and how uncertain it is (infinite: there was no rest to tare on)."""

    values: Array
    offset: float
    offset_std: float


def tare(time: Array, values: Array, window: tuple[float, float], *, least_samples: int = 20) -> Tared:
    """Take the mean over the rest window off `values`; unchanged where the window is too short.

    The mean leaves out what lies beyond four robust standard deviations; its deviation allows for correlated noise.
    """
    rest = values[(time >= window[0]) & (time <= window[1])]
    rest = rest[np.isfinite(rest)]
    if rest.size < least_samples:
        return Tared(values, 0.0, 0.0)
    spread = 1.4826 * float(np.median(np.abs(rest - np.median(rest))))
    kept = rest[np.abs(rest - np.median(rest)) <= 4.0 * spread]
    offset = float(np.mean(kept))
    error = float(np.std(kept) * np.sqrt(autocorrelation_time(kept) / kept.size))
    return Tared(values - offset, offset, error)


def tare_unsigned_speed(time: Array, speed: Array, window: tuple[float, float], *, memory: float = 0.05) -> Tared:
    """Take the rest value of an unsigned tachometer off its magnitude; `speed` [rad/s] had its sign put on afterwards.

    The sign is that of the running median over `memory` [s]: the noise of a single sample has none of its own.
    """
    _, signed, error = tare(time, speed, window)
    period = float(np.median(np.diff(time))) if time.size > 1 else memory
    half = max(1, round(0.5 * memory / period))
    direction = np.sign(median_filter(np.nan_to_num(speed), 2 * half + 1, mode="nearest"))
    return Tared(speed - direction * abs(signed), abs(signed), error)


def glitch_mask(values: Array, *, half_width: int, peak: float, foot: float) -> Mask:
    """Return where a glitch stands out from the median of its surroundings (Hampel), shape of `values`.

    Monotonic transients, however steep, are their own median and pass.

    Args:
        values: evenly spaced samples; NaN never is a glitch.
        half_width: of the surroundings, in samples: longer than a glitch, shorter than the signal's own pulses.
        peak: least distance that makes a glitch, in the unit of `values`.
        foot: a glitch extends to where its distance falls below this.
    """
    known = np.isfinite(values)
    if not np.any(known):
        return np.zeros(values.shape, dtype=bool)
    filled = np.interp(np.arange(values.size), np.flatnonzero(known), values[known])
    distance = np.abs(filled - median_filter(filled, 2 * half_width + 1, mode="nearest"))
    regions, _ = label(distance > foot)
    guilty = np.unique(regions[distance > peak])
    return known & np.isin(regions, guilty[guilty > 0])


def ringing_mask(time: Array, throttle_time: Array, throttle: Array, *, jump: float, span: float, hold: float) -> Mask:
    """Return where a load cell rings: within `hold` [s] after the throttle changed by `jump` [V] within `span` [s].

    A throttle that passes through zero hits the structure as hard as a jump does where the motor stops or turns, so
    the change counts wherever it happens.
    """
    earlier = np.interp(throttle_time - span, throttle_time, throttle)
    jumps = throttle_time[np.abs(throttle - earlier) >= jump]
    if jumps.size == 0:
        return np.zeros(time.shape, dtype=bool)
    latest = np.searchsorted(jumps, time, side="right") - 1
    return (latest >= 0) & (time - jumps[np.maximum(latest, 0)] < hold)


def cell_means(
    time: Array, values: Array, *, start: float, width: float, cells: int, least_share: float = 0.5
) -> tuple[Array, Array]:
    """Return (centres, means) over `cells` cells of `width` [s] from `start` [s].

    A cell is NaN when it has less than `least_share` of the samples that cells have, by the median of those with any: a
    burst of late samples in one of them takes nothing from the others.
    """
    index = np.floor((time - start) / width + 1e-9).astype(np.int64)
    inside = (index >= 0) & (index < cells) & np.isfinite(values)
    counts = np.bincount(index[inside], minlength=cells)
    sums = np.bincount(index[inside], weights=values[inside], minlength=cells)
    usual = float(np.median(counts[counts > 0])) if np.any(counts) else 0.0
    enough = counts >= max(1.0, least_share * usual)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.where(enough, sums / counts, np.nan)
    return np.asarray(start + width * (np.arange(cells) + 0.5), dtype=np.float64), np.asarray(means, dtype=np.float64)


def noise_level(values: Array) -> float:
    """Return the standard deviation of white noise in evenly spaced `values`, from third differences.

    Third differences of a smooth signal vanish; of white noise they have the variance 20 sigma^2. The median makes
    the estimate deaf to steps and spikes. Four equal readings say nothing of noise: so reads a tachometer that is blind
    at low speed, or a coarse converter. Never below a millionth of the signal's range: samples without noise would
    otherwise weigh infinitely. NaN where fewer than ten differences are left.
    """
    differences = np.diff(values, 3)
    known = np.isfinite(differences)
    if np.sum(known) < _FEWEST:
        return float("nan")
    moved = np.diff(values) != 0.0
    telling = known & (moved[:-2] | moved[1:-1] | moved[2:])
    differences = differences[telling if np.sum(telling) >= _FEWEST else known]
    found = float(np.median(np.abs(differences)) / 0.6744897501960817 / np.sqrt(20.0))
    return max(found, 1e-6 * float(np.nanmax(values) - np.nanmin(values)))
