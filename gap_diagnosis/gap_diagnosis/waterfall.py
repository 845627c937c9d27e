"""The waterfall by channel, in its unit: what each step leaves on runs left out, and what no model predicts."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.problem import Problem
from system_identification.noise import Whitener

__all__ = ["channels_left_out", "floors_of", "moved_by_pushes"]

Array = NDArray[np.float64]
_DEAF = 1e4
"""Times their noise by which readings are off in a filter that learns nothing of them, and rounds off nothing yet."""


def channels_left_out(diagnosis: Diagnosis, found: Investigation) -> Iterator[dict[str, float]]:
    """Yield for each step of the waterfall the root mean square of its errors, by channel in its unit."""
    problem: Problem = found.none.system
    for predicted in _predicted(diagnosis, found):
        squares = (problem.measured - predicted) ** 2
        yield {
            _channel(problem, signal): float(np.sqrt(np.nanmean(squares[rows[problem.known[rows]]])))
            for signal, rows in problem.signal_rows.items()
            if np.any(problem.known[rows])
        }


def _predicted(diagnosis: Diagnosis, found: Investigation) -> Iterator[Array]:
    """Yield predictions (R,) of each step of the waterfall, left out except as stated."""
    yield found.as_stated
    if diagnosis.nearest:
        yield from (each.out.predicted for each in diagnosis.nearest)
        return
    yield found.held_out(found.none).predicted
    keys = found.best.keys
    for step in diagnosis.waterfall[2:]:
        yield found.held_out(found.search.weighed[frozenset(keys[: keys.index(step.name) + 1])]).predicted


def floors_of(found: Investigation) -> dict[str, Mapping[str, tuple[float, float]]]:
    """Return what a right model would be off by: (over the noise, in the unit) by channel, with pushes and without."""
    problem: Problem = found.none.system
    moved = moved_by_pushes(found.noise)
    own = {signal: found.left.noise.level(signal) for signal in problem.signal_names}
    pushed = {signal: float(np.hypot(own[signal], moved[signal])) for signal in own}
    return {
        name: {_channel(problem, signal): (level[signal] / own[signal], level[signal]) for signal in own}
        for name, level in (("disturbance", pushed), ("noise", own))
    }


def moved_by_pushes(noise: Whitener) -> dict[str, float]:
    """Return how far random pushes move the readings of each signal, root mean square in its unit.

    By the filter of the noise, made deaf: what it does not learn of readings is what pushes do to them.
    """
    levels, system = noise.levels, noise.system
    sensors = {name: _DEAF * level for name, level in levels.sensors.items()}
    silent = dict.fromkeys(levels.colours, 0.0)
    deaf = replace(noise, levels=replace(levels, sensors=sensors, colours=silent), wild=None, loose=None)
    still = replace(deaf, levels=replace(deaf.levels, pushes=tuple(0.0 for _ in levels.pushes)))
    squares = np.where(system.known, np.maximum(deaf.deviations**2 - still.deviations**2, 0.0), 0.0)
    total, count = dict.fromkeys(system.signal_names, 0.0), dict.fromkeys(system.signal_names, 0)
    for each in system.series:
        total[each.signal] += float(np.sum(squares[each.rows]))
        count[each.signal] += int(np.sum(system.known[each.rows]))
    return {name: float(np.sqrt(total[name] / max(count[name], 1))) for name in total}


def _channel(problem: Problem, signal: str) -> str:
    """Return the name of a signal's channel."""
    return next(problem.recordings[s.recording].channel(signal) for s in problem.series if s.signal == signal)
