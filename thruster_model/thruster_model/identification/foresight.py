"""What recordings would determine of a set's parameters, before any fit."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from thruster_model.identification.experiment import Experiment
from thruster_model.identification.fit import check_experiments, noise_of
from thruster_model.identification.identifiability import Determination, determinations
from thruster_model.identification.problem import problem_of
from thruster_model.parameter_set import ParameterSet

__all__ = ["foreseen"]


def foreseen(parameter_set: ParameterSet, experiments: Sequence[Experiment]) -> tuple[Determination, ...]:
    """Return how far experiments would determine each parameter that a fit adjusts, at the values of the set.

    The model is taken as right and the sensors' noise as white: the best that a fit can do. Clocks and rest values
    that are uncertain are unknowns beside the parameters.

    Raises:
        UnfitDataError: nothing that a fit would take.
    """
    noise = noise_of(experiments)
    check_experiments(experiments, noise)
    posed = problem_of(parameter_set, experiments, noise)
    given = parameter_set.model.of_role("given")
    posed = replace(posed, free=tuple(name for name in parameter_set.model.parameter_names if name not in given))
    free = len(posed.free)
    start = np.clip(posed.start, *posed.bounds)
    jacobian = posed.jacobian(start)  # the priors' rows, of one, are the last
    covariance = np.linalg.inv(jacobian.T @ jacobian)
    deviations = np.sqrt(np.diag(covariance))
    return determinations(
        posed.model,
        posed.free,
        np.array([parameter_set.values[name] for name in posed.free]),
        deviations[:free] * posed.scales,
        (covariance / np.outer(deviations, deviations))[:free, :free],
        np.linalg.norm(jacobian[: -start.size, :free], axis=0),
        posed.scales,
    )
