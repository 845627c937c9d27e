"""One study: several models fitted to the same runs and judged against a reference, on those runs and on others."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.errors import UnfitDataError
from thruster_model.identification.evaluation import (
    Comparison,
    Evaluation,
    compare,
    evaluate,
    fit_shifts,
    shifts_of,
)
from thruster_model.identification.experiment import Experiment
from thruster_model.identification.fit import FitOptions, FitResult, fit, noise_of
from thruster_model.identification.hold_out import leave_one_out
from thruster_model.identification.prediction import predict
from thruster_model.parameter_set import ParameterSet

__all__ = ["FittedModel", "Study", "run_study"]

Array = NDArray[np.float64]
BLOCK_SECONDS = 2.0


@dataclass(frozen=True, kw_only=True)
class FittedModel:
    """One model's fit, its reference and their errors.

    Attributes:
        result: of the fit.
        reference: the parameter set to compare with: published, or the truth of a synthetic campaign.
        fitted: errors on the runs of the fit.
        comparison: of the two, signal by signal and in total.
        held_out: errors on each run of a fit to the others, and their comparison; None where it was not asked for.
        validation: comparison on runs that no fit has seen; empty where there are none.
        predictions: of the fit, by (experiment index, signal), on the measurement's cells.
    """

    result: FitResult
    reference: ParameterSet
    fitted: Evaluation
    comparison: tuple[Comparison, ...]
    held_out: tuple[Evaluation, tuple[Comparison, ...]] | None
    validation: tuple[Comparison, ...]
    predictions: dict[tuple[int, str], Array]

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.result.parameter_set.model_name

    @property
    def coefficients(self) -> ThrusterCoefficients:
        """Of the fit."""
        return self.result.parameter_set.coefficients


@dataclass(frozen=True, kw_only=True)
class Study:
    """All models of a study with the runs they were fitted to and those kept for validation."""

    experiments: tuple[Experiment, ...]
    validation: tuple[Experiment, ...]
    models: tuple[FittedModel, ...]


def run_study(
    starts: Sequence[tuple[ParameterSet, ParameterSet]],
    experiments: Sequence[Experiment],
    *,
    validation: Sequence[Experiment] = (),
    hold_out: bool = False,
    options: FitOptions | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Study:
    """Fit every model and judge it.

    Args:
        starts: (start, reference) of each model.
        experiments: to fit.
        validation: to predict only.
        hold_out: whether to repeat each fit with each run left out.
        options: of the fits.
        progress: told what is being done.

    Raises:
        UnfitDataError: nothing to fit, or a run to predict only that measures nothing which a model predicts.
    """
    _check_validation(starts, validation)
    models = []
    for start, reference in starts:

        def told(text: str, name: str = start.model_name) -> None:
            progress(f"{name}: {text}")

        models.append(_fit_one(start, reference, experiments, validation, hold_out, options, told))
    return Study(experiments=tuple(experiments), validation=tuple(validation), models=tuple(models))


def _check_validation(starts: Sequence[tuple[ParameterSet, ParameterSet]], validation: Sequence[Experiment]) -> None:
    problems = []
    for experiment in validation:
        for signals in dict.fromkeys(start.model.signals for start, _ in starts):
            if not set(signals) & set(experiment.measurements):
                expected, found = ", ".join(signals), ", ".join(experiment.measurements)
                text = f"expected one of {expected}; found {found}"
                problems.append(f"{experiment.name}: nothing to predict: {text}")
    if problems:
        raise UnfitDataError(problems)


def _fit_one(
    start: ParameterSet,
    reference: ParameterSet,
    experiments: Sequence[Experiment],
    validation: Sequence[Experiment],
    hold_out: bool,
    options: FitOptions | None,
    progress: Callable[[str], None],
) -> FittedModel:
    noise = noise_of(experiments)
    result = fit(start, experiments, options, progress)
    progress("errors")
    shifts = fit_shifts(result.parameter_set, experiments, noise)
    fitted = evaluate(result.parameter_set, experiments, noise, shifts)
    referenced = evaluate(reference, experiments, noise)
    held_out = None
    if hold_out and len(experiments) > 1:
        left_out = leave_one_out(start, experiments, options, progress)
        held_out = (left_out, compare(left_out, referenced, block=_block(experiments)))
    seen = {**noise_of(validation), **noise}
    judged: tuple[Comparison, ...] = ()
    if validation:
        pair = [evaluate(s, validation, seen) for s in (result.parameter_set, reference)]
        judged = compare(pair[0], pair[1], block=_block(validation))
    return FittedModel(
        result=result,
        reference=reference,
        fitted=fitted,
        comparison=compare(fitted, referenced, block=_block(experiments)),
        held_out=held_out,
        validation=judged,
        predictions=_predictions(result.parameter_set, experiments, shifts),
    )


def _block(experiments: Sequence[Experiment]) -> int:
    widths = [m.width for e in experiments for m in e.measurements.values()]
    return max(1, round(BLOCK_SECONDS / float(np.median(widths))))


def _predictions(
    parameter_set: ParameterSet, experiments: Sequence[Experiment], shifts: Array
) -> dict[tuple[int, str], Array]:
    found = {}
    for index, late in enumerate(shifts_of(parameter_set, experiments, shifts)):
        predicted = predict(experiments[index], parameter_set.coefficients, late, parameter_set.effects)
        found.update({(index, signal): values for signal, values in predicted.items()})
    return found
