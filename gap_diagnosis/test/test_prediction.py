"""Predictions at the recording's own stamps."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.blind_check.signals import rich_campaign
from gap_diagnosis.prediction import Situation, predict
from gap_diagnosis.preparing import recording_of
from thruster_model.flow_tank import simulate
from thruster_model.parameter_set_io import load_parameter_set


@pytest.mark.parametrize(
    "effect",
    [
        {"command_delay": {"time": 0.0}},
        {"command_lag": {"time": 2e-5}},
        {"log_alignment": {"load": 0.0}},
        {"flow_delay": {"time": 0.0}},
        {"clock_drift": {"rate": 0.0}},
        {"coulomb_friction": {"deceleration": 0.0}},
    ],
)
def test_an_effect_of_no_size_predicts_for_fast_readings_what_none_predicts(effect):
    stated, (recording,) = campaign(model="hq", seed=1, runs=1)
    at: np.ndarray = np.arange(3000) * 0.005
    slow = recording.experiment.measurements["speed"]
    wavy = np.interp(at, slow.time, slow.values) + np.random.default_rng(1).standard_normal(at.size)
    fast = recording_of(
        "fast", (at[::8], 3.0 * np.interp(at[::8], slow.time, np.sign(slow.values))), {"speed": (at, wavy)}
    )
    coefficients = stated.model.coefficients(stated.values)
    none, found = (predict(fast, coefficients, e, Situation(start=fast.start))["speed"] for e in ({}, effect))
    assert np.sqrt(np.mean((none - found) ** 2)) < 0.01, "a fit would take the difference for the effect"


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


def test_a_lagging_command_is_predicted_as_the_generator_integrates_it():
    stated = load_parameter_set("simplified")
    programme = dict(list(rich_campaign(np.random.default_rng(2), duration=15.0).items())[:1])
    effect = {"command_lag": {"time": 0.12}}
    truth = Truth(model="simplified", parameters=dict(stated.values), effects=effect)
    (run,) = generate(truth, programme, closed_loop=False, seed=2)
    signals = {"speed": "n", "thrust": "thrust", "torque": "torque"}
    recorded = {name: run.recorded[channel] for name, channel in signals.items()}
    throttle = run.recorded["throttle"]
    recording = recording_of(
        "lag", (throttle.time, throttle.values), {name: (r.time, r.values) for name, r in recorded.items()}
    )
    found = predict(recording, stated.model.coefficients(stated.values), effect, Situation(start=recording.start))
    for name, noise in (("speed", 1.2), ("thrust", 0.25), ("torque", 4e-4)):
        difference = found[name] - run.clean[signals[name]]
        assert np.sqrt(np.mean(difference**2)) < 0.1 * noise, name


@pytest.mark.parametrize("period", [1.0 / 60.0, 0.01, 0.007, 0.002, 0.001])
def test_samples_faster_than_the_bench_logs_are_predicted_as_they_were_taken(period):
    """Speed in a curve: means over too few samples, or over cells that do not hold as many each, would be off."""
    stated, _ = campaign(model="hl", seed=1, runs=1)
    coefficients = stated.model.coefficients(stated.values)
    at: np.ndarray = period * np.arange(round(8.0 / period))
    throttle = np.where(at < 0.5, 0.0, np.where(np.floor(at + 1e-9) % 2 == 0, 3.0, -2.0))
    exact = simulate(coefficients, np.repeat(throttle, 4), period / 4.0, largest_step=1e-3).n[:-1:4]
    values = exact + 1e-3 * np.random.default_rng(1).standard_normal(at.size)
    recording = recording_of("fast", (at, throttle), {"speed": (at, values)})
    predicted = predict(recording, coefficients, {}, Situation(start=recording.start))["speed"]
    off = predicted - recording.experiment.measurements["speed"].values
    assert np.sqrt(np.nanmean(off**2)) < 0.1
