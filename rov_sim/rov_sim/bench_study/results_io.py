"""The shards of a bench study: how one is computed, and finished ones read from their folder."""

from pathlib import Path

from rov_sim.bench_study.controllers import EXTRA, THESIS
from rov_sim.bench_study.experiment import KINDS, SCORES, Experiment, run_experiment, score
from rov_sim.bench_study.plan_io import conditions_of
from rov_sim.study.results import Results
from rov_sim.study.results_io import finished_shards, read_results
from rov_sim.study.store_io import Scores, Shard, Store, scores_of

__all__ = ["UNITS", "read_study", "run_shard"]

UNITS = {
    "rmse": "N", "rmse_true": "N", "largest": "N", "overshoot": "1", "settling": "s", "chatter": "V", "n_hat": "rad/s",
    "v_hat": "m/s", "U_hat": "m/s", "v_spread": "m/s", "speed": "rad/s",
}  # fmt: skip


def run_shard(plan: str, shard: Shard) -> Scores:
    """Return the scores of a shard; a pure function of its arguments."""
    given = conditions_of(plan)
    experiments = (Experiment(shard.strategy, shard.reference, seed) for seed in range(shard.first, shard.last))
    return scores_of(SCORES, (score(run_experiment(each, given), shard.reference) for each in experiments))


def read_study(folder: Path) -> tuple[str, Results]:
    """Return the plan and all results of a study's folder.

    Raises:
        ValueError: no study, or strategies with other seeds than the rest.
    """
    plan, shards = finished_shards(folder, (*THESIS, *EXTRA), tuple(KINDS))
    return plan, read_results(Store(folder, plan, SCORES), shards)
