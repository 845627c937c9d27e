"""Air at the propeller comes at random: what the states foresee is something else."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign, noise_of

from gap_diagnosis.discrepancy import chosen_greedily
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.ventilation import _viterbi, air_beside
from system_identification.fitting import fit
from system_identification.hypothesis import Hypothesis
from system_identification.loose import Loose


def beside(problem):
    noise = noise_of(problem)
    fitted = fit(problem, noise, problem.start())
    none = np.zeros(problem.known.size)
    return Hypothesis(suspects=(), fitted=fitted, noise=noise, loose=Loose({}, none))


def found(effects, outside, seed):
    stated, recordings = campaign(effects, outside=outside, seed=seed, spread=0.0, duration=30.0, runs=4)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    return air_beside(beside(problem))


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_thrust_that_collapses_at_random_is_found_with_its_share(seed):
    air = found({"ventilation": {"share": 0.4, "onset": 60.0}}, None, seed)
    assert air.grid[0, 0] * air.slots[0].width == pytest.approx(0.4, abs=0.1)
    assert sum(int(np.sum(np.diff(gate) != 0.0)) for gate in air.gates) > 4
    assert air.price > 4.0


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_outliers_of_a_load_cell_to_either_side_are_no_air(seed):
    stated, recordings = campaign(seed=seed, spread=0.0, duration=30.0, runs=4)
    rng = np.random.default_rng(seed)
    noisy = []
    for recording in recordings:
        thrust = recording.experiment.measurements["thrust"]
        hit = rng.random(thrust.values.size) < 0.02
        loud = thrust.values + np.where(hit, 1.5 * rng.standard_normal(hit.size), 0.0)
        measurements = {**recording.experiment.measurements, "thrust": replace(thrust, values=loud)}
        noisy.append(replace(recording, experiment=replace(recording.experiment, measurements=measurements)))
    problem = Problem(recordings=tuple(noisy), parameter_set=stated, deviations=deviations_of(stated))
    air = air_beside(beside(problem))
    assert air is None or air.price > 20.0


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_thrust_that_collapses_after_each_quick_change_of_speed_is_not_taken_for_air(seed):
    assert found(None, {"wake_stall": {"share": 0.5}}, seed) is None


def test_a_recording_without_a_load_cell_is_no_obstacle_to_air_in_another():
    stated, recordings = campaign(
        {"ventilation": {"share": 0.4, "onset": 60.0}}, seed=3, spread=0.0, duration=30.0, runs=3
    )
    blind = recordings[0].experiment
    kept = {name: m for name, m in blind.measurements.items() if name in ("speed", "ambient")}
    recordings[0] = replace(recordings[0], experiment=replace(blind, measurements=kept))
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    air = air_beside(beside(problem))
    assert air.grid[0, 0] * air.slots[0].width == pytest.approx(0.4, abs=0.15)


@pytest.mark.parametrize(
    ("odds", "air", "changes"), [([5.0, 5.0, -9.0], [1, 1, 0], 2), ([-9.0, 9.0, 9.0], [0, 1, 1], 1)]
)
def test_every_change_of_a_path_is_counted_that_of_a_start_in_air_too(odds, air, changes):
    states, gain, counted = _viterbi(np.array(odds), -2.0)
    assert states.tolist() == air and counted == changes
    assert gain == pytest.approx(sum(o for o, a in zip(odds, air, strict=True) if a) - 2.0 * changes)


def test_where_there_is_nothing_to_choose_from_nothing_is_chosen():
    assert chosen_greedily(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 6) == ([], [], 0.0)
