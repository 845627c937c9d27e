"""A nameless disturbance is found in the block where it enters."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign, noise_of

from gap_diagnosis.disturbances import block_evidence
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.where import block_shares
from system_identification.fitting import fit


def evidence_of(outside):
    stated, recordings = campaign(outside=outside, seed=5, duration=15.0, runs=2)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    return block_evidence(fit(problem, noise_of(problem), problem.start()), noise_of(problem))


@pytest.mark.parametrize(
    ("block", "outside"),
    [
        ("flow", {"tank_seiche": {"gain": 0.015, "frequency": 0.2}}),
        ("sensor", {"load_cell_creep": {"share": 0.4, "time": 2.0}}),
        ("log", {"clock_jump": {"time": 0.15, "when": 0.5}}),
        ("log", {"clock_jump": {"time": -0.3, "when": 0.5}}),
        ("thrust", {"low_speed_exponent": {"exponent": 1.2}}),
    ],
)
def test_a_disturbance_without_a_name_is_found_in_its_block(block, outside):
    evidence = evidence_of(outside)
    assert max(evidence, key=evidence.get) == block and evidence[block] > 20.0


def test_what_turns_the_rotor_is_found_in_its_drive():
    evidence = evidence_of({"drive_resonance": {"share": 0.7, "frequency": 1.0}})
    # Command and rotor differ only by what the dead zone hides.
    assert set(sorted(evidence, key=evidence.get)[-2:]) == {"command", "rotor"}


def test_recordings_need_not_have_the_same_channels():
    stated, recordings = campaign(outside={"load_cell_creep": {"share": 0.4, "time": 2.0}}, seed=5, runs=2)
    few = campaign(outside={"load_cell_creep": {"share": 0.4, "time": 2.0}}, seed=6, runs=1, channels=("n", "ambient"))
    problem = Problem(recordings=(*recordings, *few[1]), parameter_set=stated, deviations=deviations_of(stated))
    evidence = block_evidence(fit(problem, noise_of(problem), problem.start()), noise_of(problem))
    assert max(evidence, key=evidence.get) == "sensor"


def test_where_nothing_disturbs_no_block_has_evidence():
    assert max(evidence_of({}).values()) < 6.0


def test_shares_of_the_unknown_follow_the_evidence_and_sum_to_one():
    shares = dict(block_shares({"coulomb_friction": 0.2}, 0.8, {"flow": 100.0, "sensor": 10.0}))
    assert np.isclose(sum(shares.values()), 1.0)
    assert shares["flow"] > 0.79 and np.isclose(shares["rotor"], 0.2, atol=1e-3)


def test_what_the_samples_show_counts_although_no_suspect_stands_for_it():
    assert dict(block_shares({}, 0.0, {}, ["sensor"])) == {"sensor": 1.0}


def test_what_pushes_the_rotor_is_read_through_scale_and_cross_talk_of_a_sensor():
    stated, recordings = campaign(seed=5, duration=8.0, runs=1)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    (plain,) = problem.linear(problem.start())
    read = replace(problem, fixed={"load_cell_scale": {"share": 0.3}, "load_cell_crosstalk": {"gain": -20.0}})
    (seen,) = read.linear(read.start())
    thrust, torque = (plain.signals == problem.signal_names.index(name) for name in ("thrust", "torque"))
    # thrust and torque are samples of one message: their rows stand side by side; the chain is crosstalk, then scale
    wanted = 1.3 * (plain.readings[thrust] - 20.0 * plain.readings[torque])
    assert np.allclose(seen.readings[thrust], wanted, rtol=1e-5, atol=1e-5)
    assert np.max(np.abs(wanted)) > 1.0
    assert np.allclose(seen.readings[torque], 1.3 * plain.readings[torque], rtol=1e-5, atol=1e-8)
