"""How well parameter sets describe experiments: errors per signal and in total, with block-bootstrap errors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from thruster_model.identification.experiment import SIGNALS, Experiment
from thruster_model.identification.prediction import Shifts
from thruster_model.identification.problem import problem_of
from thruster_model.identification.weights import RobustLoss, weighted
from thruster_model.parameter_set import ParameterSet

__all__ = ["Comparison", "Evaluation", "bootstrap_errors", "compare", "evaluate", "fit_shifts"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """Residuals, measured less predicted, of one parameter set.

    Attributes:
        residuals: by (experiment index, signal), on that measurement's cells (M,), NaN where masked.
        noise: standard deviation of a cell mean, by signal.
    """

    residuals: Mapping[tuple[int, str], Array]
    noise: Mapping[str, float]

    @property
    def signals(self) -> tuple[str, ...]:
        """The signals that were measured and predicted, in their usual order."""
        present = {signal for _, signal in self.residuals}
        return tuple(name for name in SIGNALS if name in present)

    def rmse(self, signal: str, experiment: int | None = None) -> float:
        """Return the root mean square error of a signal in its unit, over one experiment or all."""
        chosen = [r for (i, s), r in self.residuals.items() if s == signal and experiment in (None, i)]
        joined = np.concatenate(chosen) if chosen else np.empty(0)
        joined = joined[np.isfinite(joined)]
        return float(np.sqrt(np.mean(joined**2))) if joined.size else float("nan")

    @property
    def total(self) -> float:
        """The noise-weighted total: root mean square over all cells of error over noise (1: nothing but noise)."""
        joined = np.concatenate([r / self.noise[s] for (_, s), r in self.residuals.items()])
        return float(np.sqrt(np.nanmean(joined**2)))


def fit_shifts(parameter_set: ParameterSet, experiments: Sequence[Experiment], noise: Mapping[str, float]) -> Array:
    """Return the clock shifts, in their standard deviations, that suit a parameter set best, shape (S,).

    Where clocks are uncertain, each set is judged with the shifts that suit it, so that no set gains by the clocks.
    """
    problem = problem_of(parameter_set, experiments, noise)
    if not problem.start.size:
        return problem.start
    # The error of a model dwarfs the noise and remembers: weighted so, the priors on clocks and rest values count.
    problem = weighted(problem, problem.start)
    loss = RobustLoss(knee=2.0 / np.sqrt(problem.memory), priors=problem.start.size)
    start, bounds = problem.start, problem.bounds
    solution = least_squares(problem.residuals, start, jac=problem.jacobian, bounds=bounds, loss=loss, max_nfev=15)
    return np.asarray(solution.x)


def evaluate(
    parameter_set: ParameterSet,
    experiments: Sequence[Experiment],
    noise: Mapping[str, float],
    shifts: Array | None = None,
) -> Evaluation:
    """Return the errors of a parameter set on experiments; `shifts` as of `fit_shifts`, which is the default."""
    problem = problem_of(parameter_set, experiments, noise)
    unknowns = fit_shifts(parameter_set, experiments, noise) if shifts is None else shifts
    stacked = problem.residuals(unknowns)
    residuals = {}
    first = 0
    for row in problem.rows:
        series = np.full(experiments[row.experiment].measurements[row.signal].values.size, np.nan)
        series[row.cells] = stacked[first : first + row.cells.size] * noise[row.signal]
        first += row.cells.size
        residuals[row.experiment, row.signal] = series
    return Evaluation(residuals=residuals, noise=noise)


def shifts_of(parameter_set: ParameterSet, experiments: Sequence[Experiment], unknowns: Array) -> list[Shifts]:
    """Return the shifts that `fit_shifts` found as clock shifts of each experiment."""
    noise = dict.fromkeys(SIGNALS, 1.0)
    return problem_of(parameter_set, experiments, noise).shifts(unknowns)


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Two evaluations of the same experiments, a signal at a time.

    `error` and `reference` are root mean square errors, `difference_error` is the standard error of their difference
    by a paired block bootstrap, `interval` the 90 % interval of the error by the same, in the signal's unit ("total":
    dimensionless).
    """

    signal: str
    error: float
    reference: float
    difference_error: float
    interval: tuple[float, float]

    @property
    def worse(self) -> bool:
        """Whether the error exceeds the reference by more than its standard error."""
        return self.error - self.reference > self.difference_error


def compare(
    evaluation: Evaluation, reference: Evaluation, *, block: int, draws: int = 500, seed: int = 1
) -> tuple[Comparison, ...]:
    """Compare two evaluations signal by signal, then in total.

    Args:
        evaluation, reference: of the same experiments.
        block: length of the blocks, in cells: longer than residuals remember.
        draws, seed: of the bootstrap.
    """
    rows = []
    keys = [key for key in evaluation.residuals if key in reference.residuals]
    for signal in [*(s for s in SIGNALS if any(k[1] == s for k in keys)), "total"]:
        chosen = [key for key in keys if signal in (key[1], "total")]
        unit = {key: evaluation.noise[key[1]] if signal == "total" else 1.0 for key in chosen}
        ours = [evaluation.residuals[key] / unit[key] for key in chosen]
        theirs = [reference.residuals[key] / unit[key] for key in chosen]
        first, second = bootstrap_errors([ours, theirs], block=block, draws=draws, seed=seed)
        rows.append(
            Comparison(
                signal=signal,
                error=float(np.sqrt(np.nanmean(np.concatenate(ours) ** 2))),
                reference=float(np.sqrt(np.nanmean(np.concatenate(theirs) ** 2))),
                difference_error=float(np.std(first - second)),
                interval=(float(np.quantile(first, 0.05)), float(np.quantile(first, 0.95))),
            )
        )
    return tuple(rows)


def bootstrap_errors(
    alternatives: Sequence[Sequence[Array]], *, block: int, draws: int = 500, seed: int = 1
) -> list[Array]:
    """Return bootstrap draws of the root mean square error of each alternative, each of shape (draws,).

    Blocks of `block` cells are drawn with replacement over all series, the same for every alternative (paired).
    """
    squares = [_block_sums(series, block) for series in alternatives]
    counts = squares[0][1]
    chosen = np.random.default_rng(seed).integers(0, counts.size, size=(draws, counts.size))
    total = np.maximum(counts[chosen].sum(axis=1), 1.0)
    return [np.sqrt(sums[chosen].sum(axis=1) / total) for sums, _ in squares]


def _block_sums(series: Sequence[Array], block: int) -> tuple[Array, Array]:
    sums, counts = [], []
    for values in series:
        for first in range(0, values.size, block):
            piece = values[first : first + block]
            piece = piece[np.isfinite(piece)]
            if piece.size:
                sums.append(float(np.sum(piece**2)))
                counts.append(float(piece.size))
    return np.array(sums), np.array(counts)
