"""What a log shows before any physics: repeated samples, spikes, values on a lattice, stamps that scatter."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, uniform_filter1d
from scipy.stats import binom

from gap_diagnosis.rules import LOG_RULES
from thruster_model.identification.preparation import noise_level

__all__ = [
    "edge_deviation",
    "hole_around_zero",
    "lattice_step",
    "lone_samples",
    "regular_stamps",
    "repeated_samples",
    "spikes",
    "within_hole",
]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
LONGEST_REPEAT = 25
_DECIMALS, _WHOLE = 0.2, 0.05  # share of a step that a last decimal is at most, and how far from whole numbers of it
_BY_CHANCE = 1e-4  # probability of so many repeats, below which they are the log's
_ALIKE = 1e-3  # of the median difference: two that are closer are one, but for the decimals they were written with
_ABOUT_ZERO, _INSIDE = 4.0, 1e-3  # standard deviations that noise about zero reaches; share of outliers in a hole
_SUDDEN = 3.0  # times as far as the sample before
_WANDERS = 0.7  # share of the deviation of stamps that lasts longer than some fifty samples


def lattice_step(values: Array, *, least_values: int = 4) -> float:
    """Return the step of the lattice on which all values lie; 0 where there is none or too few different values.

    The step is the smallest distance between different values; all others must be multiples of it to one part in a
    thousand, or to the last decimal that they were written with. Noisy readings of a fine converter lie on a fine
    lattice: whether that matters is for the caller.
    """
    distinct = np.unique(values[np.isfinite(values)])
    if distinct.size < least_values:
        return 0.0
    gaps = np.diff(distinct)
    gaps = gaps[gaps > 1e-9 * max(np.ptp(distinct), 1e-300)]
    step = float(np.min(gaps, initial=np.inf))
    if not np.isfinite(step) or np.ptp(distinct) / step > 1e6 or distinct.size > 0.6 * np.sum(np.isfinite(values)):
        return 0.0
    found = step
    for _ in range(_ROUNDS):  # of many gaps the mean is known well, and with it how many steps the widest ones are
        multiples = np.round(gaps / found)
        found = float(np.sum(gaps) / np.sum(multiples))
    off = np.abs(gaps - found * multiples)
    exact = np.max(off) < 1e-3 * np.max(gaps)
    return found if exact or np.max(off) < 1.01 * _last_decimal(gaps, found) else 0.0


def _last_decimal(gaps: Array, step: float) -> float:
    """Return the unit of the decimals with which values were written, by the distances between them; 0: none is seen.

    Rounded, distances of one step are of two sizes, one such unit apart.
    """
    apart = np.diff(np.unique(gaps))
    unit = float(np.min(apart[apart > 1e-6 * step], initial=np.inf))
    count = gaps / unit
    told = unit < _DECIMALS * step and np.max(np.abs(count - np.round(count))) < _WHOLE
    return unit if told else 0.0


def hole_around_zero(values: Array, *, least: int = 5) -> float:
    """Return the magnitude below which a sensor gives zero, or noise about zero; 0 where there is no such hole.

    There must be zeros, and as many different readings between the hole's edge and its double as would betray readings
    inside: on a coarse lattice the first step is none. Where zeros have noise, readings must fall to them from one
    sample to the next, much faster than they fell before: a rotor that slows down does not.
    """
    known = values[np.isfinite(values)]
    size = np.abs(known)
    noisy = np.count_nonzero(known == 0.0) < least
    zero = _ABOUT_ZERO * float(np.nan_to_num(noise_level(known))) if noisy and known.size else 0.0
    beyond = np.sort(size[size > zero])
    outliers = int(_INSIDE * known.size) if noisy else 0
    if known.size - beyond.size < least or beyond.size < least + outliers:
        return 0.0
    edge = float(beyond[outliers])
    if np.unique(beyond[(beyond >= edge) & (beyond < 2.0 * edge)]).size < least:
        return 0.0
    return edge if not noisy or (edge > 2.0 * zero and _falls(size, zero, least)) else 0.0


def within_hole(values: Array, hole: float) -> Mask:
    """Return which readings are the zeros of a hole of such a width."""
    return np.asarray(np.abs(values) < 0.5 * hole)


def edge_deviation(readings: Sequence[Array], hole: float) -> float:
    """Return how far the edge of a hole may be off: the smallest reading beyond it has noise, which is not told."""
    beyond = sum(int(np.count_nonzero(~within_hole(v, hole) & (np.abs(v) < 2.0 * hole))) for v in readings)
    noise = max(float(np.nan_to_num(noise_level(v[np.isfinite(v)]))) for v in readings)
    return float(np.hypot(hole / max(beyond, 1), noise))


def _falls(size: Array, zero: float, least: int) -> bool:
    """Tell whether magnitudes (M,) fall to zero from one sample to the next, though they had hardly fallen before."""
    last = 1 + np.flatnonzero((size[:-2] > zero) & (size[1:-1] > zero) & (size[2:] <= zero))
    before = np.maximum(np.abs(size[last] - size[last - 1]), zero / _ABOUT_ZERO)
    sudden = size[last] - size[last + 1] > _SUDDEN * before
    return bool(np.count_nonzero(sudden) >= least and np.mean(sudden) > 0.25)


def repeated_samples(values: Array) -> Mask:
    """Return which samples repeat the one before them though a noisy sensor would not, shape (M,).

    Stretches of zeros and long constant stretches are the sensor's, not the log's. Where values lie on a lattice,
    chance repeats some: nothing is marked unless there are three times as many as the noise would repeat, and more than
    chance alone makes, also on whole rpm or on two lattices, of which a rotor runs through too many to show a step.
    """
    same = np.zeros(values.size, dtype=bool)
    same[1:] = (values[1:] == values[:-1]) & (values[1:] != 0.0)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], same, [False])).astype(np.int8)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if last - first > LONGEST_REPEAT:
            same[first:last] = False
    step, noise = lattice_step(values[~same]), noise_level(values)
    most = min(1.0, step / (2.0 * np.sqrt(np.pi) * noise)) if noise > 0.0 else float(step > 0.0)
    enough = float(np.mean(same)) >= max(0.003, 3.0 * most)
    return same if enough and not _repeat_by_chance(values, same) else np.zeros(values.size, dtype=bool)


def _repeat_by_chance(values: Array, same: Mask) -> bool:
    """Tell whether readings come again no more often than they come with some other difference, up or down.

    By chance, differences near zero are all as likely. On a lattice, or on several, a difference of one step comes up
    and down as often each as none at all; among readings without steps no difference comes twice.
    """
    apart = np.sort(np.abs(np.diff(values))[~same[1:]])
    apart = apart[apart > 0.0]
    if not apart.size:
        return False
    alike = np.searchsorted(apart, apart + _ALIKE * np.median(apart), side="right") - np.arange(apart.size)
    repeats = int(np.count_nonzero(same))
    return bool(binom.sf(repeats - 1, repeats + int(np.max(alike)), 1.0 / 3.0) > _BY_CHANCE)


def spikes(values: Array, noise: float, *, limit: float = 6.0) -> Mask:
    """Return which samples of a slow signal (a flow) stand out of their neighbours, shape (M,).

    First those more than `limit` deviations away from the median of their neighbours: it bears many spikes, but cuts
    the peaks of a signal that is sampled slowly. Of these remain the ones that are as far from the parabola through
    the other neighbours, the deviation of the parabola itself included.
    """
    known = np.isfinite(values)
    if np.sum(known) < 4 * _NEIGHBOURS or not noise > 0.0:
        return np.zeros(values.size, dtype=bool)
    filled = np.interp(np.arange(values.size), np.flatnonzero(known), values[known])
    distance = filled - median_filter(filled, 2 * _NEIGHBOURS + 1, mode="mirror")
    spread = float(np.median(np.abs(distance[known])) / 0.6745)
    # While the signal climbs, most samples are the median of their window: that is no sign of little noise.
    climbing = float(np.quantile(np.abs(np.diff(filled)), 0.25) / (0.3186 * np.sqrt(2.0)))
    deviation = max(min(noise, spread), 0.7 * min(noise, climbing), 1e-12)
    standing_out = known & (np.abs(distance) > limit * deviation)
    suspected = np.flatnonzero(standing_out)
    for _ in range(_ROUNDS if suspected.size else 0):
        left = np.zeros(values.size, dtype=bool)
        left[suspected] = _from_parabola(filled, known & ~standing_out, suspected) > limit * deviation
        if np.array_equal(left, standing_out):
            break
        standing_out = left
    # Spikes come at random; what comes in groups, or is what most samples do, is the signal.
    neighbours = int(np.sum(standing_out[1:] & standing_out[:-1]))
    share = float(np.mean(standing_out))
    at_random = share < _MOST and neighbours <= 2.0 * share**2 * values.size + 5.0
    return standing_out if at_random else np.zeros(values.size, dtype=bool)


_NEIGHBOURS = 6  # to either side
_ROUNDS = 6
_MOST = 0.45  # share of samples from which on they are the signal


def _from_parabola(values: Array, used: Mask, at: NDArray[np.int64]) -> Array:
    """Return how far samples lie from the parabola through the used ones among their ten neighbours, shape of `at`.

    Divided by how many deviations of a sample that distance has; infinite where too few neighbours are used.
    """
    offsets = np.concatenate((np.arange(-5, 0), np.arange(1, 6)))
    places = at[:, None] + offsets
    inside = (places >= 0) & (places < values.size)
    places = np.clip(places, 0, values.size - 1)
    weights = (inside & used[places]).astype(np.float64)
    powers = (offsets / 5.0)[:, None] ** np.arange(3)
    inverse = np.linalg.inv(np.einsum("mw,wi,wj->mij", weights, powers, powers) + 1e-9 * np.eye(3))
    middle = np.einsum("mi,wi,mw,mw->m", inverse[:, 0], powers, weights, values[places])
    away = np.abs(values[at] - middle) / np.sqrt(1.0 + inverse[:, 0, 0])
    return np.where(np.sum(weights, axis=1) > 3, away, np.inf)


def lone_samples(values: Array, noise: float, *, limit: float = 8.0, together: int = 1) -> Mask:
    """Return which samples lie away from all their neighbours by more than `limit` deviations, shape (M,).

    For any signal: the two before it, continued, and the two after it must miss it to the same side, and be closer to
    each other than half as far. One such reading in a thousand would outweigh all the others; where there are more than
    any logger may have (and than one) they are no accident, and are left. together: how many readings a sample is the
    mean of.
    """
    lone = np.zeros(values.size, dtype=bool)
    if values.size < 5 or not noise > 0.0:
        return lone
    here, before, after = values[2:-2], values[1:-3], values[3:-1]
    from_before, from_after = here - (2.0 * before - values[:-4]), here - (2.0 * after - values[4:])
    away = here - 0.5 * (before + after)
    least = np.minimum(np.minimum(np.abs(from_before), np.abs(from_after)), np.abs(away))
    one_side = (np.sign(from_before) == np.sign(away)) & (np.sign(from_after) == np.sign(away))
    with np.errstate(invalid="ignore"):
        lone[2:-2] = one_side & (least > limit * noise) & (np.abs(after - before) < 0.5 * np.abs(away))
    most = max(LOG_RULES.ordinary * together * values.size, 1.0)
    return lone if np.sum(lone) <= most else np.zeros(values.size, dtype=bool)


def regular_stamps(stamps: Array) -> tuple[Array, float]:
    """Return (regular stamps through these ones [s], standard deviation of these about them [s]).

    Stamps that jump, wander or pause do not scatter: they come back as they are, with 0.
    """
    index = np.arange(stamps.size)
    if stamps.size < 8:
        return stamps, 0.0
    slope, first = np.polyfit(index, stamps, 1)
    if not slope > 0.0:
        return stamps, 0.0
    regular = first + slope * index
    residual = stamps - regular
    kept = np.abs(residual) <= 4.0 * max(float(np.median(np.abs(residual))) / 0.6745, 1e-12)
    if np.sum(kept) > 0.5 * stamps.size:
        slope, first = np.polyfit(index[kept], stamps[kept], 1)
        regular = first + slope * index
    residual = stamps - regular
    scatter = float(np.std(residual))
    if float(np.std(uniform_filter1d(residual, min(51, stamps.size // 2)))) > _WANDERS * scatter:
        return stamps, 0.0
    period = _round_period(float(slope), scatter * np.sqrt(12.0) / stamps.size**1.5)
    regular += (period - slope) * (index - np.mean(index))
    return np.asarray(regular), scatter if scatter < 3.0 * slope else 0.0


def _round_period(period: float, deviation: float) -> float:
    """Return the whole rate [Hz] or tenth of a millisecond that a logger was set to, where that is as likely [s]."""
    choices = [1.0 / max(round(1.0 / period), 1), max(round(period * 1e4), 1) * 1e-4]
    nearest = min(choices, key=lambda choice: abs(choice - period))
    return nearest if abs(nearest - period) < 3.0 * deviation else period
