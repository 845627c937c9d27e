"""How far free runs of the model go astray over a stated horizon, on recordings that its numbers were not fitted to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.filtering import Prepared, filtered
from gap_diagnosis.vehicle.gram import Gram, solution
from gap_diagnosis.vehicle.model import Key, Model
from gap_diagnosis.vehicle.search import Found, Stage
from rov_sim.vehicle.effects.active import ActiveVehicleEffect

__all__ = ["CHANNEL_GROUPS", "Errors", "Point", "free_run_errors", "left_out_errors"]

Array = NDArray[np.float64]
CHANNEL_GROUPS = {
    "attitude": (slice(0, 3), "rad"),
    "gyro": (slice(3, 6), "rad/s"),
    "depth": (slice(9, 10), "m"),
    "velocity": (slice(10, 13), "m/s"),
}
_WARM = 2.0  # s of filter before each free run


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Root mean squares by channel group at the end of the horizon: with the model as it is, re-tuned, with the
    effects; NaN: not measured."""

    horizon: float
    as_is: Mapping[str, float]
    retuned: Mapping[str, float]
    with_effect: Mapping[str, float]


class Point(NamedTuple):
    """A point of the model: numbers and effects that are on."""

    values: Mapping[Key, float]
    effects: Sequence[ActiveVehicleEffect]


def left_out_errors(found: Found, horizon: float) -> Errors:
    """Return the errors of each run predicted from numbers of the other runs; with one run, from its own."""
    first, last = found.stages[0], found.stages[-1]
    runs = last.screen.runs
    compared = [
        [Point({}, ()) for _ in runs],
        [Point(_without(first, found, k), ()) for k in range(len(runs))],
        [Point(_without(last, found, k), last.screen.effects) for k in range(len(runs))],
    ]
    tables = free_run_errors(last.screen.model, runs, compared, horizon)
    return Errors(horizon=horizon, as_is=tables[0], retuned=tables[1], with_effect=tables[2])


def free_run_errors(
    model: Model, runs: Sequence[Prepared], compared: Sequence[Sequence[Point]], horizon: float
) -> list[dict[str, float]]:
    """Return root mean square errors by channel group at the end of free runs, for each set of points, one a run."""
    found = []
    for points in compared:
        errors = np.concatenate(
            [np.reshape(_free_runs(model, run, *at, horizon), (-1, 13)) for run, at in zip(runs, points, strict=True)]
        )
        squares = {name: np.square(errors[:, columns]) for name, (columns, _) in CHANNEL_GROUPS.items()}
        there = {name: each[np.isfinite(each)] for name, each in squares.items()}
        found.append({name: float(np.sqrt(np.mean(s))) if s.size else float("nan") for name, s in there.items()})
    return found


def _without(stage: Stage, found: Found, k: int) -> dict[Key, float]:
    """Return the nuisances as the other runs have them; biases of the run itself are its own."""
    gram, m = stage.gram, len(found.nuisances)
    values = dict(stage.screen.values)
    if len(gram.by_run) > 1:
        A, b, rr = gram.by_run[k]
        others: Gram = replace(gram, A=gram.A - A, b=gram.b - b, rr=gram.rr - rr)
        shifts, _ = solution(others, range(m))
        for (key, deviation), shift in zip(found.nuisances.items(), shifts, strict=True):
            if key[0] not in ("gyro", "force"):
                values[key] = values.get(key, 0.0) + float(shift) * deviation
    return values


def _free_runs(
    model: Model, run: Prepared, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect], horizon: float
) -> list[Array]:  # fmt: skip
    """Return the errors (13,) at the end of each free run, begun anew from the filter's state."""
    log = run.log
    warm, free = round(_WARM / log.period), round(horizon / log.period)
    found = []
    for first in range(0, log.count - warm - free - 1, max(free, warm)):
        last = first + warm + free + 6
        gains = run.gains.gains[first:last].copy()
        gains[warm:] = 0.0
        speed_gains = run.speed_gains[first:last].copy()
        speed_gains[warm:] = 0.0
        part = replace(
            run, log=log.part(first, min(last, log.count)), gains=run.gains._replace(gains=gains),
            speed_gains=speed_gains,
        )  # fmt: skip
        error = filtered(model, part, values, effects).body[warm + free :]
        with np.errstate(all="ignore"):
            found.append(np.array([_first_finite(column) for column in error.T]))
    return found


def _first_finite(values: Array) -> float:
    good = values[np.isfinite(values)]
    return float(good[0]) if good.size else float("nan")
