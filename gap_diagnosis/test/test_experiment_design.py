"""The next experiment tells apart what poor recordings cannot; the recordings come from the independent generator."""

import csv
import json

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.blind_check.store_io import write_generated_run
from gap_diagnosis.cli_diagnose import main
from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.experiment_design import design, distances
from gap_diagnosis.experiment_inputs import Limits, programmes
from gap_diagnosis.experiment_io import command_period, experiment_content
from gap_diagnosis.experiment_rivals import rivals_of
from gap_diagnosis.experiment_words import as_sentence
from gap_diagnosis.preparing import recording_of
from thruster_model.effects.stages import LIBRARY
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
CHANNELS = {"n": "speed", "ambient": "ambient", "thrust": "thrust", "torque": "torque"}
SLOW = np.interp(np.arange(500), [0, 50, 250, 450, 475, 500], [0.0, 0.0, 2.2, 1.5, 1.5, 1.5])
LAGS = ("tach_lag", "command_lag")
LIMITS = {"duration": 20.0, "period": 0.04, "largest": 2.5}


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    with threadpool_limits(1):
        yield


def truth(effects):
    rng = np.random.default_rng(3)
    parameters = {name: value * (1.0 + 0.03 * rng.standard_normal()) for name, value in HL.values.items()}
    return Truth(model="hl", parameters=parameters, effects=effects)


def generated(effects, name, throttle, seed):
    return generate(truth(effects), {name: throttle}, closed_loop=False, seed=seed)[0]


def recorded(effects, name, throttle, seed):
    run = generated(effects, name, throttle, seed).recorded
    signals = {signal: (run[c].time, run[c].values) for c, signal in CHANNELS.items()}
    return recording_of(name, (run["throttle"].time, run["throttle"].values), signals)


def all_but(*kept):
    return tuple(name for name in LIBRARY if name not in kept)


@pytest.fixture(scope="module")
def poor():
    return recorded({"tach_lag": {"time": 0.033}}, "slow", SLOW, 1)


@pytest.fixture(scope="module")
def found(poor):
    return diagnose([poor], HL, excluded=all_but(*LAGS))


@pytest.fixture(scope="module")
def proposed(found):
    return design(found, **LIMITS)


def test_a_slow_ramp_does_not_tell_a_slow_tachometer_from_a_slow_driver(found):
    assert not [c for c in found.verdict.claims if c.group_probability > 0.9 and not c.alike]


def test_the_experiment_separates_what_the_recordings_did_not(proposed):
    assert {name for each in proposed.separates for name in each.candidates} & set(LAGS)
    for each in proposed.separates:
        assert each.distance_now < 3.0
        assert each.distance > 5.0 * each.distance_now


def test_no_random_programme_separates_the_closest_pair_better_and_the_median_one_far_worse(found, proposed):
    rivals, pairs = rivals_of(found)
    limits = Limits(largest=2.5, rate=HL.values["u_dot_max"], duration=20.0, dead_zone=(-1.0, 1.0))
    noise = {n: found.investigation.noise.level(n) for n in found.investigation.noise.levels.sensors}
    least = [min(distances(each, rivals, pairs, noise)) for each in programmes(limits, count=27, seed=99)]
    chosen = min(each.distance for each in proposed.separates)
    assert chosen > 1.5 * np.median(least)
    assert chosen > 0.9 * np.max(least)


def test_the_experiment_keeps_to_the_limits_of_the_rig_and_of_the_parameter_set(proposed):
    throttle = proposed.programme.throttle
    assert throttle.size == 500
    assert np.max(np.abs(throttle)) <= 2.5
    assert np.max(np.abs(np.diff(throttle))) <= 0.04 * HL.values["u_dot_max"] + 1e-12
    assert not np.any(throttle[:25]) and not np.any(throttle[-25:])


def test_old_and_new_recordings_together_name_the_effect_that_the_old_ones_could_not(poor, proposed):
    new = recorded({"tach_lag": {"time": 0.033}}, "next", proposed.programme.throttle, 7)
    verdict = diagnose([poor, new], HL, excluded=all_but(*LAGS)).verdict
    assert verdict.verdict == "effect"
    assert [(claim.effect, claim.alike) for claim in verdict.claims] == [("tach_lag", ())]
    assert verdict.claims[0].sizes["time"].value == pytest.approx(0.033, abs=3.0 * 0.001)


def test_the_same_seed_gives_the_same_experiment_and_the_content_says_what_it_is_for(found, proposed):
    again = design(found, **LIMITS)
    assert np.array_equal(again.programme.throttle, proposed.programme.throttle)
    content = json.loads(json.dumps(experiment_content(proposed), allow_nan=False))
    assert content["file"] == "next_experiment.csv"
    assert content["duration_s"] == pytest.approx(20.0)
    assert len(content["programme"]["time"]) == len(content["programme"]["throttle"]) == 500
    assert all(set(each) == {"candidates", "distance", "distance_now"} for each in content["separates"])
    assert any(name in content["sentence"] for name in LAGS)


def test_exact_twins_are_called_inseparable_with_the_measurement_that_would_settle_it():
    late = recorded({"command_delay": {"time": 0.06}}, "late", SLOW, 2)
    kept = all_but("command_delay", "log_alignment")
    proposed = design(diagnose([late], HL, excluded=kept), **LIMITS, count=18)
    (sentence,) = [s for s in proposed.inseparable if "command_delay" in s]
    assert "No throttle experiment tells" in sentence and "log_alignment:throttle" in sentence
    assert "stamps taken on the device" in sentence and "the voltage at the motor's terminals" in sentence
    assert {"command_delay", "log_alignment:throttle"} not in [set(s.candidates) for s in proposed.separates]


def test_twins_stay_inseparable_where_one_of_them_ends_at_its_range():
    late = recorded({"command_delay": {"time": 0.15}}, "late", SLOW, 2)
    found = diagnose([late], HL, excluded=all_but("command_delay", "log_alignment"))
    assert [(claim.effect, claim.alike) for claim in found.verdict.claims] == [
        ("command_delay", ("log_alignment:throttle",))
    ]
    proposed = design(found, **LIMITS, count=18)
    assert proposed is not None and not proposed.separates and proposed.programme is None
    assert proposed.sentence.startswith("No throttle experiment tells command_delay from log_alignment:throttle")


def test_where_an_idle_run_shows_nothing_the_experiment_shows_effects_that_it_would_not_have(poor):
    flat = recorded({}, "flat", np.full(500, 1.6), 4)
    found = diagnose([flat], HL, excluded=all_but("dead_zone_shift", "tach_lag", "thrust_asymmetry"))
    proposed = design(found, **LIMITS, count=27)
    assert found.verdict.verdict in ("cannot_tell", "no_gap", "parameters")
    assert all("none" in each.candidates for each in proposed.separates)
    assert max(each.distance for each in proposed.separates) > 10.0
    assert all(each.distance > each.distance_now for each in proposed.separates)


def test_an_experiment_that_says_little_is_to_be_played_as_often_as_three_deviations_take():
    (programme,) = programmes(Limits(largest=2.0, rate=100.0, duration=10.0), count=1, seed=0)
    said = as_sentence(programme, [(("tach_lag", "none"), 1.0, 0.5), (("tach_lag", "command_lag"), 1.0, 4.0)], [])
    assert "tach_lag from re-tuned parameters by 1.0 standard deviations (now 0.5), played 9 times by 3 in all" in said
    assert "tach_lag from command_lag by 1.0 standard deviations (now 4.0)." in said


def test_the_period_of_the_commands_is_read_from_the_recordings(poor):
    assert command_period([poor]) == pytest.approx(0.04)
    assert command_period([]) == pytest.approx(0.04)


def test_the_command_line_writes_the_experiment_where_it_is_asked_for_and_null_where_not(tmp_path, capsys):
    run = write_generated_run(generated({"tach_lag": {"time": 0.033}}, "slow", SLOW, 1), tmp_path, tuple(CHANNELS))
    without = ["--without", *all_but(*LAGS)]
    asked = ["--experiment", "--largest-throttle", "1.5", "--experiment-duration", "12"]
    assert main([str(run), "--model", "hl", "--out", str(tmp_path / "plain"), *without]) == 0
    assert json.loads((tmp_path / "plain/diagnosis.json").read_text())["next_experiment"] is None
    assert not (tmp_path / "plain/next_experiment.csv").exists()
    assert main([str(run), "--model", "hl", "--out", str(tmp_path / "asked"), *asked, *without]) == 0
    content = json.loads((tmp_path / "asked/diagnosis.json").read_text())["next_experiment"]
    assert content["sentence"] in capsys.readouterr().out
    with (tmp_path / "asked" / content["file"]).open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["time_s", "throttle_V"]
    assert [float(row["throttle_V"]) for row in rows] == pytest.approx(content["programme"]["throttle"], abs=1e-5)
    assert len(rows) == 300 and max(abs(float(row["throttle_V"])) for row in rows) <= 1.5


def test_a_wrong_limit_is_refused_before_anything_is_diagnosed(tmp_path, capsys):
    asked = ["--experiment", "--largest-throttle", "-2", "--experiment-duration", "1"]
    assert main([str(tmp_path), "--model", "hl", "--out", str(tmp_path / "out"), *asked]) == 1
    said = capsys.readouterr().err
    assert "largest throttle [V] of the next experiment: expected a positive number, found -2" in said
    assert "duration [s] of the next experiment: expected 4 to 600, found 1" in said
    assert not (tmp_path / "out").exists()
