"""Where a correction shows: the runs and the stretches of time in which it takes off most squared error."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.problem import Problem
from system_identification.noise import Whitener

__all__ = ["Telling", "run_error", "telling_runs"]

Array = NDArray[np.float64]
_STEP = 0.25  # [s], by which the window slides


class Telling(NamedTuple):
    """One run and where its errors fall most.

    Attributes:
        recording: its index.
        drop: squared error that the correction takes off, over the noise.
        start, stop: of the window in which it takes off most [s].
    """

    recording: int
    drop: float
    start: float
    stop: float


def telling_runs(
    problem: Problem, noise: Whitener, before: Array, after: Array | None, window: float = 6.0
) -> list[Telling]:
    """Return the runs, the most telling one first.

    Args:
        problem: recordings.
        noise: of their channels.
        before: predictions of all rows, shape (R,).
        after: corrected ones; None: as good as the noise allows.
        window: length of the stretch of time [s].
    """
    found = []
    for index, recording in enumerate(problem.recordings):
        time, old = _squares(problem, noise, before, index)
        new = np.ones_like(old) if after is None else _squares(problem, noise, after, index)[1]
        known = np.isfinite(old) & np.isfinite(new)
        if not np.any(known):
            continue
        time, drop = time[known], (old - new)[known]
        start, stop = _window(time, drop, recording.experiment.duration, window)
        found.append(Telling(recording=index, drop=float(np.sum(drop)), start=start, stop=stop))
    return sorted(found, key=lambda each: -each.drop)


def run_error(problem: Problem, noise: Whitener, predicted: Array, recording: int) -> float:
    """Return the RMS of one run's errors over the noise of their channels; 1 is noise alone."""
    squares = _squares(problem, noise, predicted, recording)[1]
    return float(np.sqrt(np.nanmean(squares)))


def _squares(problem: Problem, noise: Whitener, predicted: Array, recording: int) -> tuple[Array, Array]:
    """Return times [s] and squared errors over the noise of all channels of a run, NaN where unknown."""
    times, squares = [np.empty(0)], [np.empty(0)]
    for each in problem.series:
        if each.recording == recording:
            times.append(problem.recordings[recording].experiment.measurements[each.signal].time)
            error = problem.measured[each.rows] - predicted[each.rows]
            squares.append((error / noise.level(each.signal)) ** 2)
    return np.concatenate(times), np.concatenate(squares)


def _window(time: Array, drop: Array, duration: float, window: float) -> tuple[float, float]:
    if duration <= window:
        return 0.0, duration
    order = np.argsort(time)
    total = np.concatenate(([0.0], np.cumsum(drop[order])))
    starts = np.arange(0.0, duration - window + 1e-9, _STEP)
    sums = total[np.searchsorted(time[order], starts + window)] - total[np.searchsorted(time[order], starts)]
    best = float(starts[int(np.argmax(sums))])
    return best, best + window
