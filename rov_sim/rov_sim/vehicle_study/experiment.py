"""One experiment of the study: a strategy, a case, a seed. All strategies of a seed meet the same vehicle and draws."""

from functools import lru_cache
from typing import Any

from rov_sim.vehicle.loop import VehicleLoopRun, simulate_vehicle_loop
from rov_sim.vehicle_study.assumptions import Assumptions
from rov_sim.vehicle_study.conditions import Sets, drawn_vehicle, feedback_of, steering_of
from rov_sim.vehicle_study.controllers import inner_loop_of
from thruster_control.strategies import strategy
from thruster_control.vehicle_set_points import Script

__all__ = ["run_experiment"]


def run_experiment(name: str, given: Assumptions, sets: Sets, script: Script, seed: int, study: int) -> VehicleLoopRun:
    """Run the strategy `name` on the vehicle of a seed; `study`: seed of the study."""
    return simulate_vehicle_loop(
        script,
        drawn_vehicle(given, sets, (study, seed)),
        steering_of(given, sets),
        _inner_loop(name, given, sets.thrusters[strategy(name).parameter_set].coefficients,
                    sets.thrusters[given.truth].coefficients),
        feedback_of(given, sets),
        period=given.period,
        duration=given.duration,
        seed=_SEEDS * study + seed,
    )  # fmt: skip


_SEEDS = 1_000_000
"""Seeds of a study; those of another begin beyond them."""


@lru_cache(maxsize=32)
def _inner_loop(name: str, given: Assumptions, believed: Any, truth: Any) -> Any:
    # tables of refitted models take a second each
    return inner_loop_of(name, given, believed, truth)
