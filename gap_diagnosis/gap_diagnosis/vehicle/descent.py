"""Where whitened innovations are most likely, with a prior about their unknowns: by steps of Gauss and Newton.

Where a whole step does not gain, damped ones do (Levenberg and Marquardt). What the data tell is often a product, a
number times what an effect leaves: along that curved valley these creep, a whole step ends uphill, and the next one,
with columns made there, falls back into it far ahead. So where they creep one step uphill is allowed.
"""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.side_by_side import side_by_side
from system_identification.ranges import within_ranges

__all__ = ["Columns", "Descent", "Point", "descended", "normal", "product_of"]

Array = NDArray[np.float64]
Columns = list[NDArray[np.float32]]
"""d innovations / d unknowns, (rows, n) of each run."""
Point = tuple[float, Array, list[Array]]
"""Log likelihood, prior included, unknowns (n,) and innovations (rows,) of each run."""
_DAMPINGS = (0.01, 0.1, 1.0, 10.0, 100.0)
"""Of steps from where an undamped one does not gain, over the curvature of each unknown by itself."""
_ENOUGH = 0.25 * rules.SETTLED
"""Gain in log likelihood below which a step is the last one: new columns for a fifth of that were a third of all."""
_CREEP, _WORTH = 0.5, 3.0 * rules.SETTLED
"""Share of what columns foresee to be gained, below which damped steps creep (along the valley of a product they gain
14 to 35 %), and least gain for which a step uphill is worth its columns."""
_WALL = 0.05
"""Share of what columns foresee to be gained, below which damped steps end: they creep towards a wall. Where a thruster
turns slowly against a stream the filter may be wrong about the flow for seconds: 300 in log likelihood, at once."""
_ROWS = 4096
_LEAST = 1e-9


class Target(Protocol):
    """What is to be most likely."""

    @property
    def weight(self) -> Array:
        """Inverse variances of the unknowns, (n,)."""

    def held(self, x: Array) -> Array:
        """Return unknowns within their ranges."""

    def scored(self, x: Array) -> tuple[list[Array], float]:
        """Return innovations and log likelihood, prior included."""

    def made(self, x: Array, r: list[Array], known: Sequence[NDArray[np.float32]]) -> Columns:
        """Return the columns of all unknowns; `known`: those of the first ones, taken as they are."""


class Descent(NamedTuple):
    """Where it ended, the columns that led there, those last made, and where."""

    end: Point
    columns: Columns
    fresh: Columns
    made: Array


def descended(
    target: Target, x: Array, columns: Sequence[NDArray[np.float32]] = (), product: Array | None = None,
    nearby: Columns | None = None, rough: float = 0.0,
) -> Descent:  # fmt: skip
    """Return where unknowns are most likely from x on.

    Args:
        target: what is to be most likely.
        x: unknowns, (n,).
        columns: of the first unknowns, which stay as they are; product: J^T J of these, where it is known.
        nearby: columns that may do for the first steps: new ones are made where they do not lead on.
        rough: share of all that was gained below which a step is the last one.
    """
    r, score = target.scored(x)
    first = here = best = (score, x, r)
    uphill, spent = False, bool(columns)
    for _ in range(rules.FIT_STEPS):
        given, nearby = nearby, None
        fresh, made = given or target.made(here[1], here[2], columns), here[1]
        end, J, there, settled = _along(target, fresh, here, columns, product)
        if given and end[0] <= best[0] and not settled:
            continue
        if end[0] <= best[0] and (uphill or not settled):
            spent |= uphill
            end, foreseen = _damped(target, target.made(best[1], best[2], columns), best, product)
            gained = end[0] - best[0]
            settled = gained < max(_WALL * foreseen, rules.SETTLED)
            if gained < _CREEP * foreseen and foreseen > _WORTH and not spent:
                x, uphill = there, True
                r, score = target.scored(x)
                here = (score, x, r)
                continue
        gained, uphill = end[0] - best[0], False
        here = best = max(end, best, key=lambda point: point[0])
        if settled or gained < max(_ENOUGH, rough * (best[0] - first[0])):
            break
    return Descent(best, J, fresh, made)


def _damped(target: Target, J: Columns, start: Point, product: Array | None) -> tuple[Point, float]:
    """Return the best point that damped steps lead to (Levenberg and Marquardt), or the start, and what the columns
    foresee to be gained."""
    best = score, x, r = start
    H, slope = normal(J, r, x, target.weight, product)
    H += np.diag(np.maximum(target.weight, _LEAST))
    for damping in _DAMPINGS:
        there, _ = _step(target, x, H + damping * np.diag(np.diag(H)), slope)
        r_there, further = target.scored(there)
        if further > best[0]:
            best = (further, there, r_there)
        elif best[0] > score:
            break
    return best, _step(target, x, H, slope)[1]


def _step(target: Target, x: Array, H: Array, slope: Array) -> tuple[Array, float]:
    """Return where a step leads within the ranges, and what it foresees to be gained; H: J^T J and the prior's."""
    step: Array = np.linalg.solve(H, -slope).astype(np.float64)
    there = within_ranges(target.held, x, step, H, -slope)
    moved = there - x
    return there, -float(slope @ moved) - 0.5 * float(moved @ H @ moved)


def _along(
    target: Target, J: Columns, start: Point, columns: Sequence[Any], product: Array | None
) -> tuple[Point, Columns, Array, bool]:
    """Return the point after steps along columns as long as they gain, the columns, where the first one leads, and
    whether nothing more is foreseen to be gained.

    A step costs one run of the filter, new columns one for each unknown. So what a step has changed beyond what
    they foresaw corrects them (Broyden), unless they are `columns`, which stay as they are.
    """
    first = start[1]
    H, slope = normal(J, start[2], start[1], target.weight, product)
    for count in range(rules.FIT_STEPS):
        score, x, r = start
        # a limit that is never reached has neither a prior nor a column: it stays where it is
        there, foreseen = _step(target, x, H + np.diag(np.maximum(target.weight, _LEAST)), slope)
        first = there if count == 0 else first
        if foreseen < _ENOUGH:
            return start, J, first, True
        r_there, further = target.scored(there)
        if not columns:
            J, H = _corrected(J, H, there - x, [b - a for a, b in zip(r, r_there, strict=True)])
        if further <= score:
            return start, J, first, False
        start, slope = (further, there, r_there), _projected(J, r_there) + target.weight * there
    return start, J, first, False


def normal(
    J: Columns, r: Sequence[Array], x: Array, weight: Array, product: Array | None = None
) -> tuple[Array, Array]:  # fmt: skip
    """Return J^T J and the slope J^T r + W x; product: of the first columns, where it is known."""
    known = 0 if product is None else len(product)
    H = np.zeros((len(x), len(x)))
    H[known:] = sum(side_by_side(lambda each: sum(some[:, known:].T @ some for _, some in _in_parts(each)), J))
    if product is not None:
        H[:known, known:] = H[known:, :known].T
        H[:known, :known] = product
    return H, _projected(J, r) + weight * x


def _projected(J: Columns, r: Sequence[Array]) -> Array:
    """Return J^T r."""

    def of_run(k: int) -> Array:
        return np.asarray(sum(some.T @ r[k][rows] for rows, some in _in_parts(J[k])))

    return np.asarray(sum(side_by_side(of_run, range(len(J)))))


def product_of(columns: Sequence[NDArray[np.float32]]) -> Array:
    """Return the product J^T J of columns (rows, n) over all runs."""
    return np.asarray(sum(side_by_side(lambda each: sum(some.T @ some for _, some in _in_parts(each)), columns)))


def _in_parts(columns: NDArray[np.float32]) -> Iterator[tuple[slice, Array]]:
    """Yield rows and columns there, (rows, n), in double precision: sums of their squares reach 1e10."""
    for first in range(0, len(columns), _ROWS):
        rows = slice(first, first + _ROWS)
        yield rows, columns[rows].astype(np.float64)


def _corrected(J: Columns, H: Array, step: Array, change: Sequence[Array]) -> tuple[Columns, Array]:
    """Return columns (rows, n) of each run that foresee the change (rows,) that a step (n,) made, and their J^T J."""
    along = step / max(float(step @ step), 1e-12)
    short = step.astype(np.float32)
    left = [d.astype(np.float32) - each @ short for each, d in zip(J, change, strict=True)]
    across, square = np.outer(_projected(J, left), along), sum(float(each @ each) for each in left)
    flat = along.astype(np.float32)
    corrected = side_by_side(lambda k: J[k] + np.outer(flat, left[k]).T, range(len(J)))  # both by columns in memory
    return corrected, H + across + across.T + square * np.outer(along, along)
