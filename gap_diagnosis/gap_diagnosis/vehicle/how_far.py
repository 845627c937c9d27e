"""How far free runs of the model go astray over a stated horizon, on recordings that its numbers were not fitted to.

With z an error over the deviation that the filter's covariance foresees for it, noise and a random wrench as of calm
water included, and E the mean of z^2 over free runs and channels, 1 where all is right, an effect closes of the gap
that re-tuning leaves

    shrink = (E before it - E with it) / (E re-tuned - 1)

The whole gap, E as it is - 1, is shared out among re-tuning and the effects by their Shapley values, at the numbers and
sizes of the joint fit: re-tuning without an effect takes over what the effect does, and would have it all.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.descent import product_of
from gap_diagnosis.vehicle.filtering import Prepared, filtered, foreseen_deviations
from gap_diagnosis.vehicle.log import CHANNELS_OF, VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.refining import Fit, Problem
from gap_diagnosis.vehicle.rules import CALM_WRENCH
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.search import Found
from gap_diagnosis.vehicle.unknowns import OF_RUN, Key
from rov_sim.vehicle.effects.active import ActiveVehicleEffect

__all__ = [
    "FORESEEN",
    "Errors",
    "Point",
    "Share",
    "fit_without",
    "free_runs",
    "left_out_errors",
    "rms",
    "without_run",
]

Array = NDArray[np.float64]
FORESEEN = {"attitude": "rad", "gyro": "rad/s", "depth": "m", "velocity": "m/s"}
"""Sensors whose readings free runs are compared with, and the unit of their errors."""
_WARM = 2.0  # s of filter before each free run
_DRAWS, _LEVELS = 400, (5.0, 95.0)  # of the bootstrap over free runs; of its interval [%]
_LOST = 30.0  # deviations, more than an attitude can be off: farther out a free run is lost, not more or less so
_SEEN = 2.0  # standard errors by which a re-tuned model must be off for a share of it to mean anything


class Share(NamedTuple):
    """Share of a gap, and its 90 % interval."""

    share: float
    low: float
    high: float


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Root mean squares by channel group at the end of the horizon: with the model as it is, re-tuned, with the
    effects; NaN: not measured; infinite: a free run was lost.

    left_out: whether each recording was predicted from numbers of the others; there is no other than one.
    foreseen: what a right model would be off by, noise and the random wrench of calm water; NaN: not measured.
    shrinks: of the effects in order; None where re-tuning leaves nothing.
    steps: root of E as it is, re-tuned, and with each effect in turn.
    budget: shares of the whole gap: of re-tuning, of each effect, of what is left; empty where there is no gap.
    """

    horizon: float
    as_is: Mapping[str, float]
    retuned: Mapping[str, float]
    with_effect: Mapping[str, float]
    left_out: bool
    foreseen: Mapping[str, float]
    shrinks: tuple[Share | None, ...] = ()
    steps: tuple[float, ...] = ()
    budget: tuple[Share, ...] = ()


class Point(NamedTuple):
    """A point of the model: numbers and effects that are on."""

    values: Mapping[Key, float]
    effects: Sequence[ActiveVehicleEffect]


def left_out_errors(found: Found, horizons: Sequence[float]) -> tuple[Errors, ...]:
    """Return the errors of each run predicted from numbers of the other runs, over each horizon [s]; with one run, from
    its own."""
    last = found.stages[-1].screen
    model, runs = last.model, last.runs
    points: list[list[Point]] = [[Point({}, ()) for _ in runs]]
    if found.stages[0].accepted:  # the search began with effects
        points.append([Point(found.retuned, ()) for _ in runs])
    for stage in found.stages:
        points.append([without_run(stage.screen, stage.fit, found.nuisances, k) for k in range(len(runs))])
    # effects with which the search began came all at once: the last of them has their share
    together = len(found.stages[-1].accepted) - (len(points) - 2)
    joint = Point(found.stages[-1].fit.values, [a.active for a in found.stages[-1].fit.effects])
    return tuple(_errors(model, runs, points, joint, together, horizon) for horizon in horizons)


def _errors(
    model: Model, runs: Sequence[Prepared], points: Sequence[Sequence[Point]], joint: Point, together: int,
    horizon: float,
) -> Errors:  # fmt: skip
    """Return the errors at the points of each step, as stated, re-tuned, with one effect more each, over what is
    foreseen at the point of all recordings."""
    errors = [free_runs(model, runs, each, horizon) for each in points]
    spread = np.concatenate([_spreads(model, run, joint, horizon) for run in runs])
    squares = np.array([_over(each, spread) for each in errors])
    whole = [rms(each) for each in (errors[0], errors[1], errors[-1])]
    there = squares[:, np.isfinite(squares).all(axis=0)]
    shrinks = _shares(there[1:], _turns) if _is_gap(there[1]) else (None,) * (len(there) - 2)
    foreseen = rms(np.where(np.isfinite(errors[0]), spread, np.nan))
    return Errors(
        horizon=horizon, as_is=whole[0], retuned=whole[1], with_effect=whole[2], left_out=len(runs) > 1,
        foreseen=foreseen, shrinks=(None,) * together + shrinks,
        steps=tuple(np.sqrt(there.mean(axis=1)).tolist()) if there.size else (),
        budget=_budget(model, runs, points[-1], horizon, spread),
    )  # fmt: skip


def _over(errors: Array, spread: Array) -> Array:
    """Return the mean of z^2 over the channels that tell, (windows,), NaN where none does."""
    z = np.minimum(np.abs(errors / spread), _LOST) ** 2
    there = np.isfinite(z)
    return np.asarray(np.where(there, z, 0.0).sum(axis=1) / np.where(there.any(axis=1), there.sum(axis=1), np.nan))


def _is_gap(squares: Array) -> bool:
    """Return whether E of squares (windows,) is above 1 by more than chance."""
    return bool(len(squares) > 1 and squares.mean() - 1.0 > _SEEN * squares.std() / np.sqrt(len(squares)))


def _turns(E: Array) -> Array:
    """Return what each step takes of the gap of the first, from E of each (steps + 1,)."""
    return np.asarray((E[:-1] - E[1:]) / max(E[0] - 1.0, 1e-9))


def _shapley(E: Array) -> Array:
    """Return the share of each of n causes in the gap and what is left, from E of each set of them, (2^n,).

    Bit j of a set's number says whether cause j is in it.
    """
    n = int(np.log2(len(E)))
    value = np.zeros(n)
    for order in permutations(range(n)):
        there = 0
        for j in order:
            value[j] += E[there] - E[there | 1 << j]
            there |= 1 << j
    gap = max(E[0] - 1.0, 1e-9)
    return np.append(value / math.factorial(n), E[-1] - 1.0) / gap


def _budget(
    model: Model, runs: Sequence[Prepared], ended: Sequence[Point], horizon: float, spread: Array
) -> tuple[Share, ...]:  # fmt: skip
    """Return the shares of re-tuning, of each effect and of what is left."""
    on = ended[0].effects
    squares = []
    for chosen in range(2 ** (1 + len(on))):
        some = [effect for j, effect in enumerate(on) if chosen >> (1 + j) & 1]
        biases = [{k: v for k, v in at.values.items() if k[0] in OF_RUN} for at in ended]
        points = [Point(at.values if chosen & 1 else own, some) for at, own in zip(ended, biases, strict=True)]
        squares.append(_over(free_runs(model, runs, points, horizon), spread))
    table = np.array(squares)
    table = table[:, np.isfinite(table).all(axis=0)]
    return _shares(table, _shapley) if _is_gap(table[0]) else ()


def _shares(table: Array, of: Callable[[Array], Array]) -> tuple[Share, ...]:
    """Return shares of E, the rows' means (rows, windows), with their intervals by bootstrap over windows."""
    W, rng = table.shape[1], np.random.default_rng(0)
    drawn = np.array([of(table[:, rng.integers(W, size=W)].mean(axis=1)) for _ in range(_DRAWS)])
    low, high = np.percentile(drawn, _LEVELS, axis=0)
    return tuple(Share(*map(float, row)) for row in zip(of(table.mean(axis=1)), low, high, strict=True))


def rms(errors: Array) -> dict[str, float]:
    """Return root mean squares by channel group of errors (windows, 13); infinite where a free run is lost."""
    squares = {name: np.square(errors[:, CHANNELS_OF[name]]) for name in FORESEEN}
    there = {name: each[~np.isnan(each)] for name, each in squares.items()}
    return {name: float(np.sqrt(np.mean(s))) if s.size else float("nan") for name, s in there.items()}


def free_runs(model: Model, runs: Sequence[Prepared], points: Sequence[Point], horizon: float) -> Array:
    """Return the errors at the end of free runs (windows, 13), each run with its point; NaN: not measured; infinite:
    the vehicle is lost."""
    return np.concatenate(
        [np.reshape(_free_runs(model, run, *at, horizon), (-1, 13)) for run, at in zip(runs, points, strict=True)]
    )


def without_run(screen: Screen, fit: Fit, free: Mapping[Key, float], k: int) -> Point:
    """Return numbers and effects as all recordings but one have them; the one's biases are its own, its trim is not
    known. With one recording there are no others."""
    if len(fit.columns) < 2:
        return Point(fit.values, [a.active for a in fit.effects])
    found = fit_without(screen, fit, free, k)
    own = {key: value for key, value in fit.values.items() if key[0] in OF_RUN}
    values = {key: value for key, value in {**found.values, **own}.items() if key[0] != "trim"}
    return Point(values, [a.active for a in found.effects])


def fit_without(screen: Screen, fit: Fit, free: Mapping[Key, float], k: int) -> Fit:
    """Return the fit to all recordings but one, of two or more, along the columns of the joint fit.

    One step without checking what it gains (x + H^-1 J_k^T r_k, the slope of all being zero) went to a negative mass
    where an effect was missing.
    """
    others = [j for j in range(len(fit.columns)) if j != k]
    left = Screen(model=screen.model, runs=[screen.runs[j] for j in others], values={})
    problem = Problem(screen=left, nuisances=free, effects=tuple(a.hypothesis for a in fit.effects))
    columns = [fit.columns[j] for j in others]
    return problem.fit(fit.moved, [a.sizes for a in fit.effects], columns, product_of(columns))


def _windows(log: VehicleLog, horizon: float) -> tuple[range, int, int]:
    """Return first instants of free runs, how many instants each is filtered and how many it is free."""
    warm, free = round(_WARM / log.period), round(horizon / log.period)
    return range(0, log.count - warm - free - 1, max(free, warm)), warm, free


def _spreads(model: Model, run: Prepared, at: Point, horizon: float) -> Array:
    """Return the deviations (windows, 13) that the errors at the end of free runs should have in calm water.

    A random wrench that was learned as large stands for what the model lacks: with it foreseen there would be no gap.
    """
    starts, warm, free = _windows(run.log, horizon)
    calm = np.minimum(run.noises.wrench, model.wrench_of_water(CALM_WRENCH))
    run = replace(run, noises=run.noises._replace(wrench=calm))
    return foreseen_deviations(model, run, at.values, at.effects, [(k, k + warm, k + warm + free) for k in starts])


def _free_runs(
    model: Model, run: Prepared, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect], horizon: float
) -> list[Array]:  # fmt: skip
    """Return the errors (13,) at the end of each free run, begun anew from the filter's state."""
    log = run.log
    starts, warm, free = _windows(log, horizon)
    found = []
    for first in starts:
        last = first + warm + free + 6
        gains = run.gains.gains[first:last].copy()
        gains[warm:] = 0.0
        speed_gains = run.speed_gains[first:last].copy()
        speed_gains[warm:] = 0.0
        part = replace(
            run, log=log.part(first, min(last, log.count)), gains=run.gains._replace(gains=gains),
            speed_gains=speed_gains,
        )  # fmt: skip
        error = filtered(model, part, values, effects).body
        lost = part.log.telling & ~np.isfinite(error)
        found.append(np.array([_first(column) for column in np.where(lost, np.inf, error)[warm + free :].T]))
    return found


def _first(values: Array) -> float:
    there = values[~np.isnan(values)]
    return float(there[0]) if there.size else float("nan")
