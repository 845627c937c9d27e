"""What the log of a sensor shows before any physics: lost samples, stamps that scatter, coarse or blind tachometers.
An IMU that is mounted turned (`mounting`) is counted among these.

Each is taken out of the way where a recording is read. A reading that repeats a lost one is no reading, nor is the zero
of a blind tachometer between readings; readings whose stamps scatter are put where their sensor took them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.log_check import (
    edge_deviation,
    hole_around_zero,
    lattice_step,
    regular_stamps,
    repeated_samples,
    within_hole,
)
from gap_diagnosis.rules import LOG_RULES
from gap_diagnosis.scatter import probability_at, scattered_before_sorting, share_deviation
from gap_diagnosis.suspects import betrayed_by
from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.hypotheses import described, sized
from thruster_model.effects import stages

__all__ = ["Logged", "Oddity", "cleaned", "common_to"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
_FEWEST = 50
"""Readings below which nothing is said of a sensor's log."""
_AT_RANDOM = 0.5
"""Deviation of the distances between repeats over their mean, below which a slower sensor's readings were repeated on
purpose: between lost samples it is nearly 1, between those of a message every 20 ms and a reading every 25 ms 0."""
_COARSE = 0.01
"""Step of a tachometer over the largest reading of all of them from which on it is worth a word: one that has stopped
tells nothing but its noise, in whole rpm."""
_CROSSING = 1.0
"""[s] Longest stretch of zeros that a turning rotor may have crossed; in longer ones it may as well be at rest."""
_WINDOW = 5
"""Readings that one estimate takes: errors of neighbours are not independent."""


class Oddity(NamedTuple):
    """What one recording shows of one sensor: the effect that leaves such a trace, its size, how sure that is."""

    effect: str
    sensor: str
    thruster: int | None
    size: float
    deviation: float
    log_odds: float


class Logged(NamedTuple):
    """What recordings together show: an effect of a sensor, its size with deviation and unit, its probability."""

    effect: str
    sensor: str
    thruster: int | None
    parameter: str
    size: float
    deviation: float
    unit: str
    probability: float

    @property
    def words(self) -> str:
        """Name of it in a sentence."""
        of = "" if self.thruster is None else f" of thruster {self.thruster}"
        sensor = "" if self.sensor == "tachometer" else f" ({self.sensor})"
        return f"{described(self.effect).title}{of}{sensor}"

    @property
    def sentence(self) -> str:
        """Of a summary."""
        told = f"{sized(self.parameter, self.size, self.deviation, self.unit)} (p {self.probability:.2f})"
        return f"{self.words[0].upper()}{self.words[1:]}: {told}, as the log itself shows."


def cleaned(
    time: Array, values: Array, sensor: str, thruster: int | None = None, fastest: float = 0.0
) -> tuple[Array, Array, list[Oddity]]:  # fmt: skip
    """Return stamps (K,) and readings (K, m) of a sensor without what its log shows to be wrong, and that; of a
    tachometer where a thruster is named, `fastest`: largest reading of all of them."""
    found: list[Oddity] = []
    if time.size < _FEWEST:
        return time, values, found
    regular, scatter, gain = _on_regular_stamps(time, values)
    if gain > LOG_RULES.jitter:
        if _error_of(gain, values) > rules.WORTH:
            size = scattered_before_sorting(scatter, float(np.median(np.diff(regular))))
            deviation = size / np.sqrt(2.0 * time.size)
            if size > rules.TIMING:
                found.append(Oddity(betrayed_by("stamps"), sensor, thruster, size, deviation, gain))
        time = regular
    repeated = np.logical_and.reduce([repeated_samples(column) for column in values.T])
    share = float(np.mean(repeated))
    if repeated.any():
        apart = np.diff(np.flatnonzero(repeated))
        if apart.size >= 4 and np.std(apart) > _AT_RANDOM * np.mean(apart):
            deviation = share_deviation(share, time.size)
            odds = 2.0 * float(np.count_nonzero(repeated))
            found.append(Oddity(betrayed_by("repeats"), sensor, thruster, share, deviation, odds))
    time, values = time[~repeated], values[~repeated]
    if thruster is None or time.size < _FEWEST:
        return time, values, found
    unread, own = _of_tachometer(time, values[:, 0], thruster, fastest)
    return time[~unread], values[~unread], found + own


def _of_tachometer(time: Array, speed: Array, thruster: int, fastest: float) -> tuple[Mask, list[Oddity]]:
    """Return which readings (K,) are zeros of a rotor that may have turned, and what such a log shows."""
    hole, step = hole_around_zero(speed), lattice_step(speed)
    found = []
    if step > _COARSE * max(float(np.max(np.abs(speed))), fastest):
        found.append(Oddity(betrayed_by("lattice"), "tachometer", thruster, step, 1e-3 * step, LOG_RULES.certain))
    if hole <= LOG_RULES.hole:
        return np.zeros(speed.size, dtype=np.bool_), found
    zero = within_hole(speed, hole)
    deviation = edge_deviation([speed], hole)
    found.append(Oddity(betrayed_by("zeros"), "tachometer", thruster, hole, deviation, LOG_RULES.certain))
    return _crossed(time, zero), found


def _crossed(time: Array, zero: Mask) -> Mask:
    """Return which zeros stand in a stretch so short that the rotor may have turned in it, (K,)."""
    out = np.zeros(zero.size, dtype=np.bool_)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], zero, [False])).astype(np.int8)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        out[first:last] = time[last - 1] - time[first] < _CROSSING
    return out


def _on_regular_stamps(time: Array, values: Array) -> tuple[Array, float, float]:
    """Return regular stamps (K,), the scatter of the given ones about them [s], and the log odds that the sensor read
    at the regular ones: there, each reading lies nearer to the cubic through its four neighbours."""
    regular, scatter = regular_stamps(time)
    if scatter == 0.0:
        return time, 0.0, 0.0
    gain = 0.0
    for column in values.T:
        given, better = (np.mean(_from_cubic(t, column) ** 2) for t in (time, regular))
        if given > 0.0 and better > 0.0:
            gain += 0.5 * time.size / _WINDOW * float(np.log(given / better))
    return regular, scatter, gain


def _error_of(gain: float, values: Array) -> float:
    """Return the error of readings (K, m) by their stamps, over their noise: what is lost at the given stamps."""
    return float(np.sqrt(np.expm1(2.0 * _WINDOW * gain / values.size)))


def _from_cubic(time: Array, values: Array) -> Array:
    """Return how far readings lie from the cubic through two neighbours to either side, over the deviation of that."""
    t = np.stack([np.roll(time, -j)[2:-2] - time[2:-2] for j in (-2, -1, 1, 2)])
    y = np.stack([np.roll(values, -j)[2:-2] for j in (-2, -1, 1, 2)])
    distance = np.where(np.eye(4, dtype=bool)[:, :, None], 1.0, t[:, None, :] - t[None, :, :])
    distance = np.where(np.abs(distance) < 1e-6, 1e-6, distance)  # two stamps alike
    others = np.where(np.eye(4, dtype=bool)[:, :, None], 1.0, -t[None, :, :])
    weights = np.prod(others / distance, axis=1)
    away = (values[2:-2] - np.sum(weights * y, axis=0)) / np.sqrt(1.0 + np.sum(weights**2, axis=0))
    return np.asarray(away[np.isfinite(away)])


def common_to(recordings: Sequence[Sequence[Oddity]]) -> tuple[Logged, ...]:
    """Return what at least half of the recordings show, surest first."""
    places: dict[tuple[str, str, int | None], list[tuple[int, Oddity]]] = {}
    for k, each in enumerate(recordings):
        for oddity in each:
            places.setdefault((oddity.effect, oddity.sensor, oddity.thruster), []).append((k, oddity))
    found = []
    for (effect, sensor, thruster), shown in places.items():
        if 2 * len({k for k, _ in shown}) < len(recordings):
            continue
        sizes = np.array([oddity.size for _, oddity in shown])
        weights = np.array([1.0 / max(oddity.deviation, 1e-12) ** 2 for _, oddity in shown])
        size = float(weights @ sizes / weights.sum())
        deviation = max(float(weights.sum() ** -0.5), float(np.std(sizes)) / np.sqrt(len(shown)))
        odds = sum(oddity.log_odds for _, oddity in shown)
        parameter = described(effect).parameters[0]
        most = parameter.upper if effect in stages.LIBRARY else size  # an IMU may be turned by more than one askew is
        found.append(
            Logged(
                effect, sensor, thruster, parameter.name, min(size, most), deviation, parameter.unit,
                probability_at(odds),
            )
        )  # fmt: skip
    return tuple(sorted(found, key=lambda each: -each.probability))
