"""Fit one model to several experiments: in the thesis' stages, then jointly, with honest deviations."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize
from threadpoolctl import threadpool_limits

from thruster_model.errors import UnfitDataError
from thruster_model.identification.experiment import Experiment
from thruster_model.identification.identifiability import Determination, determinations
from thruster_model.identification.prediction import Shifts
from thruster_model.identification.problem import Problem, problem_of
from thruster_model.identification.uncertainty import sandwich_covariance
from thruster_model.identification.weights import RobustLoss, weighted
from thruster_model.models import Model
from thruster_model.parameter_set import ParameterSet

__all__ = ["FitOptions", "FitResult", "Stage", "check_experiments", "fit", "noise_of", "thesis_stages"]

Array = NDArray[np.float64]
Progress = Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """How to fit.

    Attributes:
        method: "least-squares" (trust region, soft-L1 loss) or "nelder-mead", as in the thesis.
        stages: "joint" (the stages give the start) or "thesis" (the stages alone).
        prior_width: see `Problem.prior_width`.
        loss_scale: residual, in weights, from which on the loss grows linearly.
        passes: joint solutions, each with the weights that the one before implies.
        frozen: parameters that are not fitted, besides those that are given.
    """

    method: str = "least-squares"
    stages: str = "joint"
    prior_width: float = 1.0
    loss_scale: float = 2.0
    passes: int = 3
    frozen: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Stage:
    """A part of the fit: which parameters, on which signals, on steady cells only or on all."""

    title: str
    free: tuple[str, ...]
    signals: tuple[str, ...]
    steady_after: float | None = None


@dataclass(frozen=True, kw_only=True)
class FitResult:
    """A fitted parameter set and how far to trust it.

    Attributes:
        parameter_set: with standard deviations.
        start: the set that the fit started from.
        free: names of the fitted parameters, (P,).
        correlation: of the estimates, (P, P).
        determinations: what the data determine, per fitted parameter.
        shifts: clock shifts of each experiment.
        noise: of each signal's cell means.
        excess, memory: see `Problem`.
        experiments: names of the runs fitted.
        message: how the solver ended.
    """

    parameter_set: ParameterSet
    start: ParameterSet
    free: tuple[str, ...]
    correlation: Array
    determinations: tuple[Determination, ...]
    shifts: tuple[Shifts, ...]
    noise: Mapping[str, float]
    excess: Mapping[str, float]
    memory: float
    experiments: tuple[str, ...]
    message: str


def thesis_stages(start: ParameterSet) -> tuple[Stage, ...]:
    """Return the thesis' order: steady-state maps, rotor, ambient and axial flow, then the maps with the flow known."""
    of_role = start.model.of_role
    maps, drive = of_role("map"), of_role("drive")
    stages = [
        Stage(title="steady-state maps", free=drive + maps, signals=("speed", "thrust", "torque"), steady_after=2.0),
        Stage(title="rotor", free=drive + of_role("rotor"), signals=("speed",)),
    ]
    if start.model.has_flow:
        stages += [
            Stage(title="ambient flow", free=of_role("ambient"), signals=("ambient",)),
            Stage(title="axial flow", free=of_role("axial"), signals=("axial",)),
        ]
    stages.append(Stage(title="maps in transients", free=maps, signals=("thrust", "torque")))
    return tuple(stages)


def noise_of(experiments: Sequence[Experiment]) -> dict[str, float]:
    """Return each measured signal's noise as the median over the experiments that have it."""
    noise: dict[str, list[float]] = {}
    for experiment in experiments:
        for name, measurement in experiment.measurements.items():
            if np.isfinite(measurement.noise) and measurement.noise > 0:
                noise.setdefault(name, []).append(measurement.noise)
    return {name: float(np.median(values)) for name, values in noise.items()}


def fit(
    start: ParameterSet,
    experiments: Sequence[Experiment],
    options: FitOptions | None = None,
    progress: Progress = lambda _: None,
) -> FitResult:
    """Fit the parameters of `start`'s model to the experiments.

    Raises:
        UnfitDataError: no experiment, or none that measures the rotor speed, thrust or torque with a throttle.
    """
    options = options or FitOptions()
    noise = noise_of(experiments)
    check_experiments(experiments, noise)
    problem = problem_of(start, experiments, noise, options.prior_width)
    with threadpool_limits(1):  # the matrices are tall and thin: threads only wait for each other
        return _fit(problem, start, options, progress)


def _fit(problem: Problem, start: ParameterSet, options: FitOptions, progress: Progress) -> FitResult:
    message = ""
    for stage in thesis_stages(start):
        progress(f"stage: {stage.title}")
        problem, message = _solve_stage(problem, stage, options)
    free = _fitted(start.model.parameter_names, start.model, options)
    problem = replace(problem, free=free)
    unknowns = np.clip(problem.start, *problem.bounds)
    if options.stages == "joint":
        for number in range(options.passes):
            progress(f"joint fit, pass {number + 1} of {options.passes}")
            problem = weighted(problem, unknowns)
            unknowns, message = _solve(problem, unknowns, options)
    return _result(problem, unknowns, start, options, message)


def check_experiments(experiments: Sequence[Experiment], sigma: Mapping[str, float]) -> None:
    """Refuse what cannot be fitted; `sigma`: noise of each signal, in its unit.

    Raises:
        UnfitDataError: no experiment, none with a throttle, or no rotor speed, thrust or torque in any.
    """
    problems = []
    if not experiments:
        problems.append("nothing to fit: expected at least one run with a throttle and a measured signal; found none")
    elif not set(sigma) & {"speed", "thrust", "torque"}:
        found = ", ".join(sorted(sigma)) or "none"
        problems.append(f"nothing to fit: expected rotor speed, thrust or torque in some run; found signals: {found}")
    if experiments and all(not np.any(e.throttle) for e in experiments):
        problems.append("nothing is excited: the throttle is zero throughout all runs")
    if problems:
        raise UnfitDataError(problems)


def _fitted(names: Sequence[str], model: Model, options: FitOptions) -> tuple[str, ...]:
    given = model.of_role("given")
    return tuple(name for name in names if name not in options.frozen and name not in given)


def _solve_stage(problem: Problem, stage: Stage, options: FitOptions) -> tuple[Problem, str]:
    signals = tuple(name for name in stage.signals if name in problem.noise)
    free = _fitted(stage.free, problem.model, options)
    staged = replace(problem, free=free, signals=signals, steady_after=stage.steady_after)
    if not signals or not free or not any(row.cells.size for row in staged.rows):
        return problem, f"stage '{stage.title}' skipped: nothing measured for it"
    unknowns = np.clip(staged.start, *staged.bounds)
    unknowns, message = _solve(weighted(staged, unknowns), unknowns, options)
    return replace(problem, fixed=staged.values(unknowns)), message


def _solve(problem: Problem, unknowns: Array, options: FitOptions) -> tuple[Array, str]:
    lower, upper = problem.bounds
    inside = np.clip(unknowns, lower + 1e-9, upper - 1e-9)
    loss = RobustLoss(knee=options.loss_scale / np.sqrt(problem.memory), priors=unknowns.size)
    if options.method == "nelder-mead":
        found = minimize(
            lambda x: float(np.sum(loss(problem.residuals(np.clip(x, lower, upper)) ** 2)[0])),
            inside,
            method="Nelder-Mead",
            bounds=list(zip(lower, upper, strict=True)),
            options={"maxfev": 400 * inside.size, "xatol": 1e-6, "fatol": 1e-6, "adaptive": True},
        )
        return np.clip(found.x, lower, upper), str(found.message)
    solution = least_squares(
        problem.residuals,
        inside,
        jac=problem.jacobian,
        bounds=(lower, upper),
        loss=loss,
        x_scale="jac",
        ftol=1e-5,
        xtol=1e-5,
        max_nfev=40,
    )
    return solution.x, str(solution.message)


def _result(problem: Problem, unknowns: Array, start: ParameterSet, options: FitOptions, message: str) -> FitResult:
    size, free = unknowns.size, len(problem.free)
    residuals = problem.residuals(unknowns)
    jacobian = problem.jacobian(unknowns)
    data = residuals.size - size
    loss = RobustLoss(knee=options.loss_scale / np.sqrt(problem.memory), priors=size)
    weights = loss(residuals**2)[1, :data]
    hessian = jacobian[:data].T @ (weights[:, None] * jacobian[:data])
    lower, upper = problem.bounds
    open_ = (unknowns > lower + 1e-6) & (unknowns < upper - 1e-6)
    scores = [s[:, open_] for s in _scores(problem, residuals, jacobian, weights)]
    covariance = np.zeros((size, size))
    covariance[np.ix_(open_, open_)] = sandwich_covariance(
        hessian[np.ix_(open_, open_)], scores, np.eye(int(open_.sum()))
    )
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlation = np.nan_to_num(covariance / np.outer(deviations, deviations))[:free, :free]
    values = problem.values(unknowns)
    stated = deviations[:free] * problem.scales
    judged = determinations(
        problem.model,
        problem.free,
        np.array([values[name] for name in problem.free]),
        stated,
        correlation,
        np.linalg.norm(jacobian[:data, :free], axis=0),
        problem.scales,
    )
    silent = {d.name for d in judged if d.status in ("not excited", "at a bound")}
    fitted = start.with_values(
        {name: values[name] for name in problem.free},
        source=f"fitted to {', '.join(e.name for e in problem.experiments)}",
        standard_deviations={
            name: None if name in silent else float(s) for name, s in zip(problem.free, stated, strict=True)
        },
    )
    return FitResult(
        parameter_set=fitted,
        start=start,
        free=problem.free,
        correlation=correlation,
        determinations=judged,
        shifts=tuple(problem.shifts(unknowns)),
        noise=problem.noise,
        excess=problem.excess,
        memory=problem.memory,
        experiments=tuple(e.name for e in problem.experiments),
        message=message,
    )


def _scores(problem: Problem, residuals: Array, jacobian: Array, weights: Array) -> list[Array]:
    """Return the scores of each experiment summed per instant over its signals, each (M, P + S)."""
    cells = [max((m.values.size for m in e.measurements.values()), default=0) for e in problem.experiments]
    scores = [np.zeros((count, jacobian.shape[1])) for count in cells]
    first = 0
    for row in problem.rows:
        part = slice(first, first + row.cells.size)
        first += row.cells.size
        scores[row.experiment][row.cells] += jacobian[part] * (weights[part] * residuals[part])[:, None]
    return scores
