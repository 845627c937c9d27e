"""One run of each strategy of a group for figures: seed 0 in the group's typical case."""

from collections.abc import Mapping

from rov_sim.vehicle.loop import VehicleLoopRun
from rov_sim.vehicle_study.experiment import run_experiment
from rov_sim.vehicle_study.plan import Group, Plan
from rov_sim.vehicle_study.results_io import sets_of
from thruster_control.vehicle_set_points_io import load_script

__all__ = ["first_runs"]


def first_runs(plan: Plan, group: Group, contents: Mapping[str, str]) -> dict[str, VehicleLoopRun]:
    """Return the runs by strategy; `contents`: of the plan's sets."""
    given, sets = plan.typical(group).assumptions, sets_of(contents)
    script = load_script(given.script)
    return {s: run_experiment(s, given, sets, script, 0, plan.seed) for s in group.strategies}
