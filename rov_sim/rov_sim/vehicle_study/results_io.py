"""The shards of a study of the vehicle: the sets that its plan names, how a shard is computed, a folder read."""

from collections.abc import Mapping
from functools import lru_cache
from itertools import product
from pathlib import Path

from rov_sim.study.results import Results, merged
from rov_sim.study.store_io import Scores, Shard, Store, scores_of, shards_of
from rov_sim.vehicle.sensors.settings_io import load_sensors
from rov_sim.vehicle_study.conditions import Sets
from rov_sim.vehicle_study.experiment import run_experiment
from rov_sim.vehicle_study.plan import Case, Plan
from rov_sim.vehicle_study.plan_io import plan_of
from rov_sim.vehicle_study.scoring import SCORES, score
from thruster_control.strategies import strategy
from thruster_control.vehicle_set_points import Script
from thruster_control.vehicle_set_points_io import load_script
from thruster_model.parameter_set_io import dump_parameter_set, load_parameter_set, parse_parameter_set
from thruster_model.vehicle_set_io import dump_vehicle_set, load_vehicle_set, parse_vehicle_set

__all__ = ["contents_of", "read_study", "results_of", "run_shard", "sets_of", "shards"]


def contents_of(plan: Plan) -> dict[str, str]:
    """Return what the plan's sets hold, as text: a study does not change when a set does."""
    cases = [case.assumptions for case in plan.all_cases.values()]
    vehicles = {name for a in cases for name in (a.vehicle, a.hull, a.layout) if name}
    thrusters = {a.truth for a in cases} | {
        strategy(s).parameter_set for group in plan.groups for s in group.strategies
    }
    found = {f"vehicle {name}": dump_vehicle_set(load_vehicle_set(name)) for name in sorted(vehicles)}
    found |= {f"thruster {name}": dump_parameter_set(load_parameter_set(name)) for name in sorted(thrusters)}
    scripts = {name: load_script(name) for name in sorted({a.script for a in cases})}
    return found | {f"script {name}": repr((s.moves.tolist(), s.end)) for name, s in scripts.items()}


def sets_of(contents: Mapping[str, str]) -> Sets:
    """Return the sets of a plan's contents."""
    texts = {tuple(key.split(" ", 1)): text for key, text in contents.items()}
    return Sets(
        vehicles={n: parse_vehicle_set(t, origin="plan") for (k, n), t in texts.items() if k == "vehicle"},
        thrusters={n: parse_parameter_set(t, origin="plan") for (k, n), t in texts.items() if k == "thruster"},
        sensors=load_sensors(),
    )


def shards(plan: Plan, seeds: int) -> list[Shard]:
    """Return the shards of a study, group by group; what is the same in two cases is computed once."""
    found: dict[Shard, None] = {}
    for group in plan.groups:
        for s, case in product(group.strategies, plan.cases(group)):
            found |= dict.fromkeys(shards_of((s,), (plan.computed_as(s, case),), seeds))
    return list(found)


def results_of(plan: Plan, store: Store, seeds: int) -> Results:
    """Return the results of a finished study, all cases of all groups."""
    parts = [(s, case) for group in plan.groups for case in plan.cases(group) for s in group.strategies]
    return merged(
        (s, case.name, store.load(shard))
        for s, case in parts
        for shard in shards_of((s,), (plan.computed_as(s, case),), seeds)
    )


def run_shard(text: str, shard: Shard) -> Scores:
    """Return the scores of a shard; a pure function of its arguments."""
    plan, cases, sets, scripts = _prepared(text)
    given, seeds = cases[shard.reference].assumptions, range(shard.first, shard.last)
    runs = (run_experiment(shard.strategy, given, sets, scripts[given.script], seed, plan.seed) for seed in seeds)
    return scores_of(SCORES, map(score, runs))


@lru_cache(maxsize=4)
def _prepared(text: str) -> tuple[Plan, Mapping[str, Case], Sets, Mapping[str, Script]]:
    plan, contents = plan_of(text)
    cases = plan.all_cases
    scripts = {name: load_script(name) for name in {case.assumptions.script for case in cases.values()}}
    return plan, cases, sets_of(contents), scripts


def read_study(folder: Path) -> tuple[str, Results]:
    """Return the plan's text and all results of a study's folder.

    Raises:
        ValueError: no study, or one that is not finished.
    """
    file = folder / "plan.json"
    if not file.exists():
        raise ValueError(f"{folder}: expected the folder of a study (plan.json); found none")
    text = file.read_text("utf-8")
    plan, store = plan_of(text)[0], Store(folder, text, SCORES)
    seeds = max((int(path.name.split("-")[-1].split(".")[0]) for path in (folder / "shards").glob("*.json")), default=0)
    if not seeds or not all(map(store.has, shards(plan, seeds))):
        raise ValueError(f"{folder}: expected a finished study; resume it first")
    return text, results_of(plan, store, seeds)
