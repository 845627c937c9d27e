"""The search for a converter's step before any is simulated."""

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.converter_steps import SPACING, likely_steps
from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.problem import Problem, deviations_of
from system_identification.fitting import fit
from system_identification.noise import white_noise


def _base(effects, channels=("n", "ambient", "thrust", "torque")):
    stated, recordings = campaign(effects, seed=3, duration=20.0, channels=channels)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    noise = white_noise(problem)
    return fit(problem, noise, problem.start()), noise


@pytest.mark.parametrize("step", [0.05, 0.11, 0.3])
def test_the_true_step_is_among_those_worth_a_trial(step):
    found = likely_steps(*_base({"command_quantization": {"step": step}}), 0.5, 60)
    assert np.min(np.abs(1.0 / found - 1.0 / step)) < 2.0 * SPACING


def test_steps_lie_in_their_range_and_none_is_given_twice():
    found = likely_steps(*_base({}), 0.5, 60)
    assert np.all((found > 0.0) & (found <= 0.5)) and np.unique(found).size == found.size


def test_without_a_reading_that_answers_there_is_nothing_to_try():
    assert likely_steps(*_base({}, channels=("ambient",)), 0.5, 60).size == 0


@pytest.mark.long
def test_a_step_whose_peak_a_coarse_grid_misses_is_named():
    stated, recordings = campaign({"command_quantization": {"step": 0.0907}}, seed=3, duration=20.0)
    (claim,) = diagnose(recordings, stated).verdict.claims
    assert claim.effect == "command_quantization"
    assert claim.sizes["step"].value == pytest.approx(0.0907, rel=0.002)
