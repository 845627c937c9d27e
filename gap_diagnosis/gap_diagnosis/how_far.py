"""How far the gap shrinks: as stated, re-tuned, with the effect, and the noise floor, all on data held out in blocks.

Recordings are cut into quarters; each fold leaves out one quarter of every recording, another one in each. A
hypothesis is fitted to the rest and simulated freely over the whole recording; what counts is the quarter left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.fitting import Fitted, fit
from gap_diagnosis.noise import NoiseModel
from gap_diagnosis.problem import Problem

__all__ = ["FOLDS", "ChannelErrors", "Errors", "Shrink", "errors_of", "folds_of", "held_out", "shrink_of"]

Array = NDArray[np.float64]
FOLDS = 4
_BLOCK = 2.0  # [s], of the bootstrap
_DRAWS = 400


@dataclass(frozen=True, kw_only=True)
class ChannelErrors:
    """Root mean squares of one channel's errors in its unit; None where no effect is claimed."""

    unit: str
    as_is: float
    retuned: float
    with_effect: float | None
    noise_floor: float


@dataclass(frozen=True, kw_only=True)
class Errors:
    """The four numbers, dimensionless in total (1 = the noise of the sensors), and by channel."""

    total: ChannelErrors
    channels: Mapping[str, ChannelErrors]


@dataclass(frozen=True, kw_only=True)
class Shrink:
    """1 - (with_effect^2 - floor^2)/(retuned^2 - floor^2), its 90 % interval, and whether there was a gap to shrink."""

    value: float | None
    interval: tuple[float, float] | None


def folds_of(problem: Problem) -> NDArray[np.int64]:
    """Return which fold each row belongs to, shape (R,)."""
    folds = np.zeros(problem.series[-1].last, dtype=np.int64)
    for each in problem.series:
        experiment = problem.recordings[each.recording].experiment
        share = experiment.measurements[each.signal].time / max(experiment.duration, 1e-9)
        folds[each.rows] = (np.clip(share * FOLDS, 0, FOLDS - 1).astype(np.int64) + each.recording) % FOLDS
    return folds


def held_out(fitted: Fitted, noise: NoiseModel) -> Array:
    """Return predictions (R,) of every row by fits that have not seen its fold."""
    folds = folds_of(fitted.problem)
    result = np.full(folds.size, np.nan)
    for k in range(FOLDS):
        kept = folds != k
        if not np.any(fitted.problem.known & ~kept) or not np.any(fitted.problem.known & kept):
            continue
        again = fit(fitted.problem, noise, fitted.x, iterations=3, rows=kept, near=fitted, polish=False)
        result[~kept] = again.problem.predicted(again.x)[~kept]
    return result


def errors_of(
    problem: Problem,
    noise: NoiseModel,
    as_is: Array,
    retuned: Array,
    with_effect: Array | None,
    units: Mapping[str, str],
) -> Errors:
    """Return root mean squares of the three predictions' errors, shape (R,) each, by channel and in total."""
    channels, totals = {}, []
    for signal, own in problem.signal_rows.items():
        rows = own[problem.known[own]]
        if not rows.size:
            continue
        floor = noise.signals[signal].marginal
        values = [
            None if p is None else float(np.sqrt(np.nanmean((problem.measured[rows] - p[rows]) ** 2)))
            for p in (as_is, retuned, with_effect)
        ]
        totals.append([None if v is None else (v / floor) ** 2 for v in values])
        name = next(problem.recordings[s.recording].channel(signal) for s in problem.series if s.signal == signal)
        channels[name] = ChannelErrors(
            unit=units[signal],
            as_is=values[0] or 0.0,
            retuned=values[1] or 0.0,
            with_effect=values[2],
            noise_floor=floor,
        )
    mean = [
        None if any(t[k] is None for t in totals) else float(np.sqrt(np.mean([t[k] for t in totals]))) for k in range(3)
    ]
    total = ChannelErrors(unit="1", as_is=mean[0] or 0.0, retuned=mean[1] or 0.0, with_effect=mean[2], noise_floor=1.0)
    return Errors(total=total, channels=channels)


def shrink_of(problem: Problem, noise: NoiseModel, retuned: Array, with_effect: Array, seed: int) -> Shrink:
    """Return the shrink with its interval by a bootstrap over blocks of 2 s; None where the excess is within noise."""
    blocks: dict[tuple[int, int], tuple[float, float, float]] = {}
    counts = {name: int(np.sum(problem.known[rows])) for name, rows in problem.signal_rows.items()}
    for each in problem.series:
        time = problem.recordings[each.recording].experiment.measurements[each.signal].time
        number = (time / _BLOCK).astype(np.int64)
        scale = noise.signals[each.signal].marginal ** 2 * max(counts[each.signal], 1) * len(counts)
        measured = problem.measured[each.rows]
        known = problem.known[each.rows] & np.isfinite(retuned[each.rows]) & np.isfinite(with_effect[each.rows])
        before = np.where(known, (measured - retuned[each.rows]) ** 2, 0.0) / scale
        after = np.where(known, (measured - with_effect[each.rows]) ** 2, 0.0) / scale
        floor = np.where(known, noise.signals[each.signal].marginal ** 2, 0.0) / scale
        for b in np.unique(number):
            here = number == b
            old = blocks.get((each.recording, int(b)), (0.0, 0.0, 0.0))
            blocks[each.recording, int(b)] = (
                old[0] + float(before[here].sum()),
                old[1] + float(after[here].sum()),
                old[2] + float(floor[here].sum()),
            )
    table = np.array(list(blocks.values()))
    excess = table[:, 0] - table[:, 2]
    if excess.sum() <= 2.0 * np.sqrt(table.shape[0]) * np.std(excess):
        return Shrink(value=None, interval=None)
    rng = np.random.default_rng(seed)
    sums = table[rng.integers(0, table.shape[0], (_DRAWS, table.shape[0]))].sum(axis=1)
    left = 1.0 - (sums[:, 1] - sums[:, 2]) / np.maximum(sums[:, 0] - sums[:, 2], 1e-12)
    total = table.sum(axis=0)
    value = float(1.0 - (total[1] - total[2]) / (total[0] - total[2]))
    low, high = np.percentile(left, [5.0, 95.0])
    return Shrink(value=value, interval=(float(low), float(high)))
