"""How far the gap shrinks, on runs left out: as stated, re-tuned, with one effect after the other, and the noise."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.problem import Problem
from system_identification.budget import PARAMETERS, Budget, Share
from system_identification.left_out import folds_of, foreseen, helps_by
from system_identification.noise import Whitener

__all__ = ["ChannelErrors", "Errors", "Shrink", "Step", "budget_of_steps", "errors_of", "shrink_of", "step_of"]

Array = NDArray[np.float64]
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
    """1 - (with_effect^2 - floor^2)/(retuned^2 - floor^2), its 90 % interval; None: there was nothing to shrink."""

    value: float | None
    interval: tuple[float, float] | None


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step of the waterfall.

    Attributes:
        name: "as_is", "retuned" or the key of the effect that is added.
        rms: of all errors over the noise, channels alike.
        by_fold: the same for each run, or part, that was left out.
        foreseen: logarithm of the probability of each of these, nats up to a constant, (F,).
        helps: probability that this step makes a new run more probable; None for the first.
    """

    name: str
    rms: float
    by_fold: tuple[float, ...]
    foreseen: Array
    helps: float | None


def step_of(
    name: str, problem: Problem, floor: Whitener, noise: Whitener, predicted: Array, before: Step | None, seed: int
) -> Step:
    """Return a step of the waterfall.

    Args:
        name: of what is added.
        problem: whose rows.
        floor: noise of the sensors, by which errors are measured.
        noise: under which runs are more or less probable.
        predicted: left out, (R,).
        before: the step before; None for the first.
        seed: of the bootstrap.
    """
    folds = folds_of(problem)
    squares = np.full((int(folds.max()) + 1, len(problem.signal_names)), np.nan)
    for k in range(squares.shape[0]):
        for s, signal in enumerate(problem.signal_names):
            rows = problem.signal_rows[signal]
            rows = rows[problem.known[rows] & (folds[rows] == k) & np.isfinite(predicted[rows])]
            if rows.size:
                errors = (problem.measured[rows] - predicted[rows]) / floor.level(signal)
                squares[k, s] = float(np.mean(np.minimum(errors**2, 1e6)))
    by_fold = np.sqrt(np.nanmean(squares, axis=1))
    rms, own = float(np.sqrt(np.nanmean(squares))), foreseen(noise, predicted)
    helps = None if before is None else helps_by(own - before.foreseen, seed)
    return Step(name=name, rms=rms, by_fold=tuple(by_fold.tolist()), foreseen=own, helps=helps)


def budget_of_steps(steps: Sequence[Step], seed: int) -> Budget:
    """Return the budget that a waterfall shows: what each step takes off the squared error beyond the noise.

    Intervals (90 %) by the Bayesian bootstrap over the runs that were left out.
    """
    squares = np.array([np.square(step.by_fold) for step in steps])
    weights = np.random.default_rng(seed).dirichlet(np.ones(squares.shape[1]), _DRAWS)
    names = [PARAMETERS, *(step.name for step in steps[2:])]

    def shares(weight: Array) -> Array:
        errors = squares @ weight - 1.0
        return np.append(errors[:-1] - errors[1:], errors[-1]) / max(float(errors[0]), 1e-9)

    central = shares(np.full(squares.shape[1], 1.0 / squares.shape[1]))
    low, high = np.percentile([shares(weight) for weight in weights], [5.0, 95.0], axis=0)
    made = [Share(float(c), float(a), float(b)) for c, a, b in zip(central, low, high, strict=True)]
    gap = float(np.sqrt(max(float(np.mean(squares[0])) - 1.0, 0.0)))
    return Budget(gap, dict(zip(names, made[:-1], strict=True)), made[-1])


def errors_of(
    problem: Problem,
    noise: Whitener,
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
        floor = noise.level(signal)
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


def shrink_of(problem: Problem, noise: Whitener, retuned: Array, with_effect: Array, seed: int) -> Shrink:
    """Return the shrink with its interval by a bootstrap over blocks of 2 s; None where the excess is within noise."""
    blocks: dict[tuple[int, int], tuple[float, float, float]] = {}
    counts = {name: int(np.sum(problem.known[rows])) for name, rows in problem.signal_rows.items()}
    for each in problem.series:
        time = problem.recordings[each.recording].experiment.measurements[each.signal].time
        number = (time / _BLOCK).astype(np.int64)
        scale = noise.level(each.signal) ** 2 * max(counts[each.signal], 1) * len(counts)
        measured = problem.measured[each.rows]
        known = problem.known[each.rows] & np.isfinite(retuned[each.rows]) & np.isfinite(with_effect[each.rows])
        before = np.where(known, (measured - retuned[each.rows]) ** 2, 0.0) / scale
        after = np.where(known, (measured - with_effect[each.rows]) ** 2, 0.0) / scale
        floor = np.where(known, noise.level(each.signal) ** 2, 0.0) / scale
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
