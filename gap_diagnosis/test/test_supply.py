"""A recording's supply voltage reaches the prediction of thrusters that are a table over it."""

import numpy as np
import pytest

from gap_diagnosis.prediction import Situation, predict
from gap_diagnosis.preparing import recording_of
from thruster_model.flow_tank import simulate
from thruster_model.parameter_set_io import load_parameter_set

P = load_parameter_set("force_table").coefficients


def test_the_measured_supply_is_that_of_the_prediction():
    t = 0.02 * np.arange(300)
    u, volts = np.where(t > 1.0, 2.5, 0.0), np.linspace(16.0, 12.5, 300)
    force = simulate(P, u, 0.02, supply=volts / 14.0).thrust[:-1]
    noise = np.random.default_rng(2).normal(0.0, 0.05, 300)
    samples = {"thrust": (t, force + noise)}
    known = recording_of("run", (t, u), samples, supply=(t, volts))
    made = predict(known, P, {}, Situation(start=known.start))["thrust"]
    assert made == pytest.approx(force, abs=0.05)
    unknown = recording_of("run", (t, u), samples)
    assert np.max(np.abs(predict(unknown, P, {}, Situation(start=unknown.start))["thrust"] - force)) > 0.5
