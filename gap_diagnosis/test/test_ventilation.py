"""Air at the propeller comes at random: what the states foresee is something else."""

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.discrepancy import chosen_greedily
from gap_diagnosis.fitting import fit
from gap_diagnosis.noise import white_noise
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.ventilation import ventilated

NOISE = white_noise({"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4})


def found(effects, outside, seed):
    stated, recordings = campaign(effects, outside=outside, seed=seed, spread=0.0, duration=30.0, runs=4)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    return ventilated(fit(problem, NOISE, problem.start()), NOISE)


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_thrust_that_collapses_at_random_is_found_with_its_share(seed):
    fitted, changes = found({"ventilation": {"share": 0.4, "onset": 60.0}}, None, seed)
    assert fitted.problem.sizes(fitted.x)["ventilation"]["share"] == pytest.approx(0.4, abs=0.03)
    assert changes > 4


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_thrust_that_collapses_after_each_quick_change_of_speed_is_not_taken_for_air(seed):
    assert found(None, {"wake_stall": {"share": 0.5}}, seed) is None


def test_where_there_is_nothing_to_choose_from_nothing_is_chosen():
    assert chosen_greedily(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 6) == ([], [], 0.0)
