"""A first look at every suspect: what parameters do by themselves, and what they cannot."""

import pytest
from generated import campaign

from gap_diagnosis.fitting import fit
from gap_diagnosis.noise import white_noise
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.screening import rated, tried
from gap_diagnosis.suspects import suspects

NOISE = white_noise({"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4})


@pytest.fixture(scope="module")
def first_look():
    stated, recordings = campaign(seed=5)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    base = fit(problem, NOISE, problem.start())
    listed = suspects({"speed", "ambient", "thrust", "torque"}, ("command_quantization",))
    return {each.suspect.key: each for each in rated(base, NOISE, tried(base, NOISE, listed))}


@pytest.mark.parametrize(
    "effect", ["throttle_gain", "thrust_loss", "load_cell_scale", "flow_scale", "viscous_friction"]
)
def test_parameters_free_of_their_deviations_imitate_scales_and_losses(first_look, effect):
    assert first_look[effect].own < 1e-3
    assert first_look[effect].is_imitable


@pytest.mark.parametrize("effect", ["load_cell_bias", "ambient_current", "tach_lag", "entrained_water"])
def test_no_parameter_imitates_offsets_and_lags(first_look, effect):
    assert first_look[effect].own > 0.1
    assert not first_look[effect].is_imitable
