"""Predictions at the recording's own stamps."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.prediction import Situation, predict


@pytest.mark.parametrize(
    "late",
    [
        {"command_delay": {"time": 0.033}},
        {"log_alignment": {"load": 0.027}},
        {"clock_drift": {"rate": 0.004}},
        {"load_cell_resonance": {"frequency": 15.0, "damping": 0.05}},
    ],
)
def test_late_readings_are_those_of_the_plant_between_its_steps(late):
    stated, (recording,) = campaign(model="simplified", seed=1, runs=1)
    coefficients = stated.model.coefficients(stated.values)
    experiment = recording.experiment
    finer = replace(experiment, dt=experiment.dt / 20.0, throttle=np.repeat(experiment.throttle, 20))
    found = predict(recording, coefficients, late, Situation(start=recording.start))
    exact = predict(replace(recording, experiment=finer), coefficients, late, Situation(start=recording.start))
    for signal, noise in (("speed", 1.2), ("thrust", 0.25), ("torque", 4e-4)):
        assert np.sqrt(np.mean((found[signal] - exact[signal]) ** 2)) < 0.15 * noise
