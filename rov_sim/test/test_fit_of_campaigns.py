"""Through the sensors of a bench, over several seeds: fits recover the truth within deviations that can be believed."""

import numpy as np
import pytest

from rov_sim.bench_campaign import altered, run_campaign
from rov_sim.campaign_io import write_bench_run
from thruster_model.identification.experiment_io import read_experiments
from thruster_model.identification.fit import fit
from thruster_model.parameter_set_io import load_parameter_set

SEEDS = (21, 22, 23, 24)


@pytest.fixture(scope="module")
def scores(tmp_path_factory):
    """(fitted - true) / stated deviation by parameter, one for each seed in which a deviation is stated."""
    found: dict[str, list[float]] = {}
    for seed in SEEDS:
        rng = np.random.default_rng(seed)
        truth = altered(load_parameter_set("hq"), 0.1, rng)
        folder = tmp_path_factory.mktemp(f"seed{seed}")
        runs = [write_bench_run(run, folder, {}) for run in run_campaign(truth, rng)]
        for name, p in fit(load_parameter_set("hq"), read_experiments(runs)).parameter_set.parameters.items():
            if p.standard_deviation:
                found.setdefault(name, []).append((p.value - truth.values[name]) / p.standard_deviation)
    return found


def test_stated_deviations_are_about_as_large_as_the_errors(scores):
    """Root mean square 1 would be perfect; ringing and turbulence that remembers are in no deviation: up to 1.8."""
    everything = np.concatenate(list(scores.values()))
    assert everything.size > 60
    assert np.sqrt(np.mean(everything**2)) < 1.8
    assert np.mean(np.abs(everything) > 3.0) < 0.1


def test_rotor_input_and_torque_are_not_biased(scores):
    for name in ("c_u1", "c_u2", "delta_u1", "delta_u2", "k_n", "k_Q", "c_n_T", "c_n_Q"):
        assert abs(np.mean(scores[name])) < 3.0 / np.sqrt(len(scores[name])) + 0.5, (name, scores[name])
