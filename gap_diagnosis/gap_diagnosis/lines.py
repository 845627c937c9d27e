"""Lines in the residuals: oscillations of one frequency that nothing in the recordings drives.

The amplitude is steady, or grows with time, with speed or with both; phases are free in each recording and signal. A
line stands out of the spectrum beside it, so that noise of any smooth colour is none (Thomson 1982, Proc. IEEE 70,
1055). At frequencies of the throttle's own lines none is looked for: what inputs drive, `discrepancy` explains.
"""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len, rfft, rfftfreq
from scipy.ndimage import maximum_filter1d, median_filter

from gap_diagnosis.prediction import Happened
from system_identification.fitting import Fitted

__all__ = ["A_LINE", "Line", "lines_of"]

Array = NDArray[np.float64]

A_LINE = "a line"
"""With which the name of every line begins."""
_FINER = 4  # frequencies for each cycle that fits into a recording
_BESIDE = 12.0  # cycles over the whole recording on either side that make the spectrum beside a line
_KNOWN_BY = 0.6 * (2.0 * _BESIDE + 1.0)  # frequencies: as good as so many averaged is the median of all
_HIGHEST = 0.8  # of the frequencies that samples can show
_AROUND = np.linspace(-1.0, 1.0, 9)  # steps of the grid at which a frequency is tried anew
_FEWEST = 60  # samples
_CHANCE = 1.0
"""Logarithm of odds that is asked of each series, where chance gives 0.3: spectra of noise have shapes of their own."""
_SHOWN = 3.0  # logarithm of odds from which a series has its wave
_DRIVEN = 6.0  # times the spectrum beside from which the throttle itself has a line
_MOST = 3
_ENVELOPES = ("", ", growing with time", ", growing with speed", ", growing with time and speed")


class Line(NamedTuple):
    """A line: name, logarithms of odds by signal and in all, and what it explains of the residuals (R,)."""

    name: str
    odds: dict[str, float]
    evidence: float
    explained: Array


class _Series(NamedTuple):
    """What the spectra of one series need: its samples, the envelopes (4, N) there, and what the throttle drives."""

    signal: str
    rows: slice
    time: Array
    step: float
    waves: Array
    driven: NDArray[np.bool_]

    @property
    def duration(self) -> float:
        return float(self.time[-1] - self.time[0])


def lines_of(fitted: Fitted, happened: Sequence[Happened]) -> list[Line]:
    """Return the lines of the residuals of a fit that stand out, the clearest one first; `happened`: in the plant."""
    series = _long_ones(fitted, happened)
    found: list[Line] = []
    left = fitted.residuals
    while series and len(found) < _MOST:
        line = _clearest(series, left)
        if line is None:
            break
        found.append(line)
        left = left - line.explained
    return found


def _clearest(series: Sequence[_Series], residuals: Array) -> Line | None:
    """Return the line that stands out most; None where none is more likely than noise."""
    longest, fastest = max(each.duration for each in series), min(each.step for each in series)
    grid = np.arange(_BESIDE / longest, 0.5 * _HIGHEST / fastest, 1.0 / (_FINER * longest))
    if grid.size < 2:
        return None
    odds = np.array([_odds(each, residuals, grid) for each in series])
    total = odds.sum(axis=0)
    shape, place = divmod(int(np.argmax(total)), grid.size)
    independent = grid.size / _FINER * len(_ENVELOPES)
    evidence = float(total[shape, place]) - np.log(independent) - _CHANCE * len(series)
    heard = [(each, odd) for each, odd in zip(series, odds[:, shape, place].tolist(), strict=True) if odd > _SHOWN]
    if evidence <= 0.0 or not heard:
        return None
    by_signal: dict[str, float] = {}
    for each, odd in heard:
        by_signal[each.signal] = by_signal.get(each.signal, 0.0) + odd
    shape, frequency = _tuned([each for each, _ in heard], residuals, grid[place] + (grid[1] - grid[0]) * _AROUND)
    explained = np.zeros(residuals.size)
    for each, _ in heard:
        explained[each.rows] = _wave(each, residuals[each.rows], shape, frequency)
    return Line(f"{A_LINE} at {frequency:.3g} Hz{_ENVELOPES[shape]}", by_signal, float(evidence), explained)


def _tuned(heard: Sequence[_Series], residuals: Array, frequencies: Array) -> tuple[int, float]:
    """Return envelope and frequency of the waves that leave least of these series, each over its variance."""
    left = {}
    for shape, frequency in product(range(len(_ENVELOPES)), frequencies.tolist()):
        rest = [residuals[each.rows] - _wave(each, residuals[each.rows], shape, frequency) for each in heard]
        left[shape, frequency] = sum(
            np.nanvar(r) / np.nanvar(residuals[e.rows]) for r, e in zip(rest, heard, strict=True)
        )
    return min(left, key=lambda each: left[each])


def _odds(series: _Series, residuals: Array, grid: Array) -> Array:
    """Return the logarithms of odds for a wave in a series, by envelope and frequency; none where it is not there."""
    here = residuals[series.rows]
    power = _over_beside(series.waves * (np.nan_to_num(here) - np.nanmean(here)), series.time, series.step)
    power[:, series.driven] = 0.0
    place = np.round(grid * _size(series.time) * series.step).astype(np.int64)
    inside = (grid >= _BESIDE / series.duration) & (grid <= 0.5 * _HIGHEST / series.step)
    ratio = power[:, np.minimum(place, power.shape[1] - 1)] * inside
    # What is beside is known from a few frequencies only: a ratio counts as one that is as rare beside a sure spectrum.
    found = _KNOWN_BY * np.log1p(ratio / _KNOWN_BY)
    return np.where(found > 1.0, found - 1.0 - np.log(np.maximum(found, 1.0)), 0.0)


def _long_ones(fitted: Fitted, happened: Sequence[Happened]) -> list[_Series]:
    """Return all series that are long enough, and whose stamps do not stand still."""
    problem = fitted.problem
    found = []
    for each in problem.series:
        known = np.isfinite(fitted.residuals[each.rows])
        experiment = problem.recordings[each.recording].experiment
        time = experiment.measurements[each.signal].time
        if each.signal in problem.opaque or np.sum(known) < max(_FEWEST, time.size // 2):
            continue
        step = float(np.median(np.diff(time)))
        if step <= 0.0:
            continue
        grid = experiment.dt * np.arange(experiment.throttle.size + 1)
        speed = np.interp(time, grid, np.abs(happened[each.recording].outputs["speed"]))
        growing = (time - time[0]) / (time[-1] - time[0])
        waves = np.array([np.ones_like(time), growing, speed, growing * speed])
        waves *= known / np.maximum(np.sqrt(np.sum(waves**2 * known, axis=1, keepdims=True)), 1e-12)
        driven = _over_beside(np.interp(time, grid[:-1], experiment.throttle)[None, :], time, step)[0] > _DRIVEN
        found.append(_Series(each.signal, each.rows, time, step, waves, maximum_filter1d(driven, 2 * _FINER + 1)))
    return found


def _size(time: Array) -> int:
    """Return of how many samples, most of them zeros, a spectrum is made."""
    return int(next_fast_len(_FINER * time.size))


def _over_beside(rows: Array, time: Array, step: float) -> Array:
    """Return spectra of rows (K, N) over what is beside each frequency, which noise exceeds x times as exp(-x)."""
    size = _size(time)
    places = np.round((time - time[0]) / step).astype(np.int64)
    inside = places < size
    on_grid = np.zeros((rows.shape[0], size))
    on_grid[:, places[inside]] = rows[:, inside]
    # The spectrum is flatter once multiplied by the square of the frequency.
    flat = np.abs(rfft(on_grid, axis=1)) ** 2 * rfftfreq(size, step) ** 2
    beside = median_filter(flat[:, ::_FINER], size=(1, 2 * int(_BESIDE) + 1), mode="nearest") / np.log(2.0)
    return np.asarray(flat / np.maximum(np.repeat(beside, _FINER, axis=1)[:, : flat.shape[1]], 1e-300))


def _wave(series: _Series, residuals: Array, shape: int, frequency: float) -> Array:
    angle = 2.0 * np.pi * frequency * series.time
    columns = series.waves[shape][:, None] * np.stack((np.sin(angle), np.cos(angle)), axis=1)
    known = np.isfinite(residuals)
    weights = np.linalg.lstsq(columns[known], residuals[known], rcond=None)[0]
    return np.asarray(columns @ weights)
