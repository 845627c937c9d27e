"""How the predictions of a problem change with its unknowns: by differences inside their ranges."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.prediction import Happened, acts_in_plant
from gap_diagnosis.suspects import ROUNDED, found_by

if TYPE_CHECKING:
    from gap_diagnosis.problem import Problem

__all__ = ["largest_speed", "movable", "sensitivities_of"]

Array = NDArray[np.float64]
_COMMANDED, _LATTICES = found_by("command_lattice"), found_by("command_lattice", "reading_lattice")
_COARSE = 0.01
"""Step [s] of the plant for its slopes: what bends within it is the same on both sides of a difference."""
_CODES = 0.01
"""Codes per volt within which what a converter adds to a throttle stays the same one, for the greater part."""
_TURN = 0.05
"""Codes at the largest speed within which what a tachometer's converter adds does."""


def movable(problem: "Problem") -> NDArray[np.bool_]:
    """Return which unknowns a fit may move, shape (K,): those that it can improve by a slope."""
    return np.array([True] * problem.nuisances + [slot.effect not in _LATTICES for slot in problem.slots])


def sensitivities_of(problem: "Problem", x: Array, columns: Sequence[int] | None = None, step: float = 1e-3) -> Array:
    """Return d predicted / d unknowns by differences inside the ranges, shape (R, K); missing rows are NaN.

    Where readings jump as a state passes a threshold, a sample that has just passed it would swamp its column: of
    the slopes to either side the smaller one counts, none where they disagree in sign. Rounded readings have the slopes
    of what is rounded, but for the step to which they are: its slope tells how sharp the peak is that was
    searched for.

    Args:
        problem: whose predictions.
        x: unknowns, shape (K,).
        columns: the unknowns that are wanted; None: all.
        step: of a size, over the width of its range; of a nuisance ten times that, in its deviations.
    """
    columns = range(x.size) if columns is None else columns
    happened = problem.happened(x)
    here = problem.predicted(x, happened=happened, without=ROUNDED)
    in_plant = any(_moves_plant(problem, k) for k in columns)
    coarse = problem.predicted(x, without=ROUNDED, largest_step=_COARSE) if in_plant else here
    result = np.zeros((here.size, len(columns)))
    for place, k in enumerate(columns):
        if k >= problem.nuisances and problem.slots[k - problem.nuisances].effect == ROUNDED:
            result[:, place] = _slope_of_step(problem, x, k, happened)
            continue
        inward = _inward(problem, k, x[k], step)
        base = coarse if _moves_plant(problem, k) else here
        slope = _slope(problem, x, k, inward, base, happened)
        if problem.jumps and _inside(problem, k, x[k] - 0.5 * inward):
            other = _slope(problem, x, k, -0.5 * inward, base, happened)
            smaller = np.where(np.abs(other) < np.abs(slope), other, slope)
            slope = np.where(other * slope > 0.0, smaller, 0.0)
        result[:, place] = slope
    result[~problem.known] = np.nan
    return result


def _slope(problem: "Problem", x: Array, k: int, step: float, here: Array, happened: Sequence[Happened]) -> Array:
    """Return the change of all rows (R,) for a unit of one unknown, by a step; `here`: predicted at `x`, coarsely for
    an unknown of the plant."""
    moved = x.copy()
    moved[k] += step
    situation = problem.situations[k - len(problem.names)] if len(problem.names) <= k < problem.nuisances else None
    only = None if situation is None else situation.recording
    known = None if _moves_plant(problem, k) else happened
    there = problem.predicted(moved, only, known, without=ROUNDED, largest_step=_COARSE)
    result = np.zeros(here.size)
    for each in problem.series:
        if only in (None, each.recording):
            result[each.rows] = (there[each.rows] - here[each.rows]) / (moved[k] - x[k])
    return result


def _slope_of_step(problem: "Problem", x: Array, k: int, happened: Sequence[Happened]) -> Array:
    """Return the change of all rows (R,) for a unit of a tachometer's step, while most codes stay the same."""
    width = problem.slots[k - problem.nuisances].width
    here = problem.predicted(x, happened=happened)
    moved = x.copy()
    moved[k] -= _TURN * x[k] ** 2 * width / largest_speed(problem, here)
    return np.asarray((problem.predicted(moved, happened=happened) - here) / (moved[k] - x[k]))


def largest_speed(problem: "Problem", predicted: Array) -> float:
    """Return the largest speed [rad/s] among predictions (R,), at least 1."""
    speeds = [predicted[each.rows] for each in problem.series if each.signal == "speed"]
    return max([1.0, *(float(np.nanmax(np.abs(each))) for each in speeds)])


def _moves_plant(problem: "Problem", k: int) -> bool:
    if k < len(problem.names):
        return True
    if k < problem.nuisances:
        return problem.situations[k - len(problem.names)].kind == "start"
    return acts_in_plant(problem.slots[k - problem.nuisances].effect)


def _inward(problem: "Problem", k: int, unit: float, step: float) -> float:
    """Return a step of an unknown that stays inside its range."""
    if k < problem.nuisances:
        return 10.0 * step
    slot = problem.slots[k - problem.nuisances]
    if slot.effect in _COMMANDED:
        step = min(step, _CODES * unit**2 * slot.width)
    return step if _inside(problem, k, unit + step) else -step


def _inside(problem: "Problem", k: int, unit: float) -> bool:
    """Tell whether an unknown may have a value: sizes are bounded by their ranges."""
    if k < problem.nuisances:
        return True
    slot = problem.slots[k - problem.nuisances]
    return slot.lower <= unit * slot.width <= slot.upper
