"""How far free runs of the model go astray over a stated horizon, on recordings that its numbers were not fitted to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.filtering import Prepared, filtered
from gap_diagnosis.vehicle.gram import Gram, solution
from gap_diagnosis.vehicle.model import Key, Model
from gap_diagnosis.vehicle.search import Found, Stage
from rov_sim.vehicle.effects.active import ActiveVehicleEffect

__all__ = ["CHANNEL_GROUPS", "Errors", "left_out_errors"]

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


def left_out_errors(found: Found, horizon: float) -> Errors:
    """Return the errors of each run predicted from numbers of the other runs; with one run, from its own."""
    first, last = found.stages[0], found.stages[-1]
    runs = last.screen.runs
    model = last.screen.model
    squares: list[dict[str, list[float]]] = [{name: [] for name in CHANNEL_GROUPS} for _ in range(3)]
    for k, run in enumerate(runs):
        options: list[tuple[Mapping[Key, float], Sequence[ActiveVehicleEffect]]] = [
            ({}, ()),
            (_without(first, found, k), ()),
            (_without(last, found, k), last.screen.effects),
        ]
        for into, (values, effects) in zip(squares, options, strict=True):
            for error in _free_runs(model, run, values, effects, horizon):
                for name, (columns, _) in CHANNEL_GROUPS.items():
                    into[name].extend(error[columns][np.isfinite(error[columns])])
    tables = [
        {name: float(np.sqrt(np.mean(np.square(each)))) if each else float("nan") for name, each in s.items()}
        for s in squares
    ]
    return Errors(horizon=horizon, as_is=tables[0], retuned=tables[1], with_effect=tables[2])


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
