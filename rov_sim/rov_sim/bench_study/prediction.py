"""Does the simulator predict the scores of the real runs: simulated against real thrust errors, run by run."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.bench_study.experiment import Conditions, Experiment, run_experiment, score
from rov_sim.bench_study.fitted_map import FittedMap
from rov_sim.bench_study.real_runs import RealRun, RecoveredMap, real_score
from rov_sim.closed_loop import Timing
from rov_sim.study.statistics import RankCorrelation, rank_correlation
from thruster_model.parameter_set import ParameterSet

__all__ = ["VARIANTS", "Prediction", "compared", "predicted_scores", "predictions", "variant"]

Array = NDArray[np.float64]

VARIANTS: Mapping[str, str] = {
    "as published": "controllers and plant with the input map of the set",
    "controllers as logged": "controllers with the input map and the table that the recordings show",
    "and plant's map fitted": "as before, and the plant's input map and the instant of sampling fitted to the rotor",
    "and flow as read": "controllers as logged, and the velocimeter's readings taken from the recording",
    "all of these": "controllers as logged, plant's map fitted, and flow as read",
}
_WITH_FLOW = ("and flow as read", "all of these")
_WITH_MAP = ("and plant's map fitted", "all of these")


class Prediction(NamedTuple):
    """Simulated against real scores [N] of K runs.

    real: (K,); simulated: (K, seeds); correlation: of the means' ranks; rmse: of the means against the real ones [N];
    constants: what the mean of the other runs would miss, and that of the others with the same set point (of all others
    where there is none) [N]; inside: how many real scores lie within the simulated 5 to 95 %.
    """

    real: Array
    simulated: Array
    correlation: RankCorrelation
    rmse: float
    constants: tuple[float, float]
    inside: int


def variant(
    name: str, given: Conditions, logged: RecoveredMap, table: Array | None, fitted: FittedMap | None
) -> Conditions:
    """Return the conditions under one of `VARIANTS`."""
    if name == "as published":
        return given
    given = replace(given, input_map=logged.input_map, table=table)
    if fitted is None or name not in _WITH_MAP:
        return given
    values = {k: v for k, v in fitted.input_map._asdict().items() if k in given.truth.parameters}
    truth = given.truth.with_values(values, source=f"{given.truth.name}, input map fitted to the recordings")
    tau = given.timing.step * round(fitted.tau / given.timing.step)
    instant = tau if given.form == "bench" else min(tau, 0.0)
    timing = Timing(**{**vars(given.timing), "sample": instant})
    return replace(given, truth=truth, timing=timing)


def predicted_scores(
    runs: Sequence[RealRun],
    given: Conditions,
    seeds: int,
    *,
    flow_as_read: bool = False,
    without: Mapping[str, ParameterSet] = MappingProxyType({}),
) -> Array:
    """Return the load cell's score [N] of each run simulated with each seed, (runs, seeds).

    without: of runs by name, the plant that was fitted without them, in the place of the one given.
    """
    out = np.empty((len(runs), seeds))
    for i, run in enumerate(runs):
        flow = run.y_U if flow_as_read else None
        own = replace(given, truth=without.get(run.name, given.truth))
        for seed in range(seeds):
            simulated = run_experiment(Experiment(run.strategy, run.reference, seed), own, flow)
            out[i, seed] = score(simulated, run.reference)["rmse"]
    return out


def predictions(
    runs: Sequence[RealRun],
    given: Conditions,
    logged: RecoveredMap,
    table: Array | None,
    fitted: FittedMap | None,
    seeds: int,
    rng: np.random.Generator,
    without: Mapping[str, ParameterSet] = MappingProxyType({}),
) -> dict[str, Prediction]:
    """Return the prediction under each of `VARIANTS`; `fitted` None: without those that have the plant's map fitted."""
    found = {}
    for name in VARIANTS:
        if fitted is None and name in _WITH_MAP:
            continue
        chosen = variant(name, given, logged, table, fitted)
        simulated = predicted_scores(runs, chosen, seeds, flow_as_read=name in _WITH_FLOW, without=without)
        found[name] = compared(runs, simulated, rng)
    return found


def compared(runs: Sequence[RealRun], simulated: Array, rng: np.random.Generator) -> Prediction:
    """Return how the simulated scores [N], (runs, seeds), compare with the real ones."""
    real = np.array([real_score(run).rmse for run in runs])
    means = simulated.mean(axis=1)
    low, high = np.percentile(simulated, (5.0, 95.0), axis=1)
    return Prediction(
        real,
        simulated,
        rank_correlation(means, real, rng),
        float(np.sqrt(np.mean((means - real) ** 2))),
        (_constant([""] * len(runs), real), _constant([run.reference for run in runs], real)),
        int(np.count_nonzero((real >= low) & (real <= high))),
    )


def _constant(groups: Sequence[str], real: Array) -> float:
    """Return by how much the mean score of a run's group without it misses it [N], of all others where it is alone."""
    missed = np.empty(real.size)
    for i, group in enumerate(groups):
        others = [k for k in range(real.size) if k != i]
        missed[i] = np.mean(real[[k for k in others if groups[k] == group] or others]) - real[i]
    return float(np.sqrt(np.mean(missed**2)))
