"""Tachometers that give magnitudes: the sign is the throttle's, and what nothing tells is left out."""

from dataclasses import replace

import numpy as np
import pytest

from gap_diagnosis.recording_io import read_recordings
from run_bag import Topic, write_run
from thruster_model.flow_tank import simulate
from thruster_model.identification.speed_sign import lacks_sign, signed_speed
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
NOISE = 0.5  # [rad/s]
TIME = np.arange(0.0, 30.0, 1e-3)


@pytest.fixture
def read(tmp_path):
    """Return (stamps, signed truth, what is read of it) of a rotor that is reversed often; `rest`: of the magnitude."""

    def made(rate, seed, rest=0.0, cut=30.0):
        rng = np.random.default_rng(seed)
        levels = np.concatenate(([0.0], rng.uniform(-4.0, 4.0, 60)))
        commands = np.repeat(levels[np.searchsorted(np.cumsum(rng.uniform(0.5, 1.5, 61)), TIME[::20])], 20)
        at = np.arange(0.0, cut - 0.01, 1.0 / rate)
        truth = np.interp(at, TIME, simulate(HL.model.coefficients(HL.values), commands, 1e-3).n[:-1])
        magnitude = np.abs(np.abs(truth) + rest + NOISE * rng.standard_normal(at.size))
        stamps = np.arange(0.0, cut, 0.02)
        topics = [
            topic("state", "ThrusterState", at, {"n": magnitude, "sign_source": np.zeros(at.size)}),
            topic("throttle", "Throttle", stamps, {"commanded": commands[np.round(stamps * 1e3).astype(int)]}),
        ]
        (recording,) = read_recordings([write_run(tmp_path / f"run_{rate}_{seed}_{rest}_{cut}", topics, {})])
        return truth, recording.experiment.measurements["speed"].values

    return made


def topic(name, kind, time, fields):
    stamps = 10**9 + np.round(time * 1e9).astype(np.int64)
    return Topic(
        name=f"thruster_0/{name}", type=f"thruster_msgs/msg/{kind}", stamps=stamps, fields=fields, frame="thruster_0"
    )


@pytest.mark.parametrize("rate", [25.0, 50.0, 100.0])
@pytest.mark.parametrize("seed", [1, 2])
def test_no_reading_has_the_wrong_sign_and_most_have_one(read, rate, seed):
    truth, speed = read(rate, seed)
    known = np.isfinite(speed)
    assert np.max(np.abs(speed - truth)[known]) < 4.5 * NOISE
    assert np.mean(known[np.abs(truth) > 10.0]) > 0.85


def test_what_a_tachometer_reads_at_rest_is_taken_off(read):
    truth, speed = read(50.0, 3, rest=6.0)
    assert np.nanmean(np.abs(speed) - np.abs(truth)) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("cut", np.arange(20.0, 22.0, 0.25))
def test_a_reversal_that_the_end_cuts_off_is_left_out(read, cut):
    truth, speed = read(50.0, 1, cut=cut)
    assert np.nanmax(np.abs(speed - truth)) < 4.5 * NOISE


def test_noise_below_zero_at_rest_does_not_make_a_magnitude_a_signed_speed():
    noise = NOISE * np.random.default_rng(5).standard_normal(500)
    magnitude = np.where(np.arange(500) < 100, 0.0, 60.0) + noise
    assert np.any(magnitude < 0.0)
    assert lacks_sign(np.zeros(500), magnitude)
    assert not lacks_sign(np.zeros(500), magnitude - 70.0 * (np.arange(500) > 300))
    assert not lacks_sign(np.ones(500), magnitude)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_rotor_that_is_never_reversed_keeps_all_its_readings(sense):
    time = np.arange(0.0, 10.0, 0.02)
    magnitude = 50.0 + 20.0 * np.sin(time)
    throttle = (np.array([0.0, 5.0]), sense * np.array([2.0, 3.0]))
    np.testing.assert_array_equal(signed_speed(time, magnitude, throttle), sense * magnitude)


def test_single_readings_whose_sign_is_unknown_are_not_measured_unless_near_rest(tmp_path):
    at = np.arange(0.0, 10.0, 0.02)
    truth = np.interp(at, [0.0, 2.0, 4.0, 5.0, 7.0, 10.0], [0.0, 0.0, 80.0, 80.0, -80.0, -80.0])
    read = truth + NOISE * np.random.default_rng(4).standard_normal(at.size)
    unsure = (at > 5.5) & (at < 6.5) | (at < 1.0)
    fields = {"n": np.where(unsure, np.abs(read), read), "sign_source": np.where(unsure, 0, 1)}
    topics = [topic("state", "ThrusterState", at, fields), topic("throttle", "Throttle", at, {"commanded": truth / 30})]
    (recording,) = read_recordings([write_run(tmp_path / "run", topics, {})])
    speed = recording.experiment.measurements["speed"].values
    assert np.isnan(speed[unsure & (np.abs(truth) > 5.0)]).all()
    assert np.isfinite(speed[~unsure]).all() and np.mean(np.isfinite(speed[at < 1.0])) > 0.95


@pytest.mark.parametrize(("channels", "sense"), [(("load", "flow"), 1.0), (("load",), -1.0), ((), -1.0)])
def test_speeds_go_against_the_throttle_only_where_two_sensors_say_that_the_thruster_does(tmp_path, channels, sense):
    at = np.arange(0.0, 30.0, 0.02)
    commands = 3.0 * np.sin(0.5 * at)
    true = simulate(HL.model.coefficients(HL.values), -np.repeat(commands, 20), 1e-3)
    n, thrust, flow = (each[:-1:20] for each in (true.n, true.thrust, true.ambient))
    read = {
        "state": topic("state", "ThrusterState", at, {"n": np.abs(n), "sign_source": np.zeros(at.size)}),
        "throttle": topic("throttle", "Throttle", at, {"commanded": commands}),
        "load": replace(topic("load", "", at, {"wrench.force.x": thrust}), type="geometry_msgs/msg/WrenchStamped"),
        "flow": topic("flow", "FlowVelocity", at, {"ambient": flow}),
    }
    run = write_run(tmp_path / "run", [read[name] for name in ("state", "throttle", *channels)], {})
    (recording,) = read_recordings([run])
    speed = recording.experiment.measurements["speed"].values
    known = np.isfinite(speed) & (np.abs(n) > 1.0)
    np.testing.assert_array_equal(np.sign(speed[known]), sense * np.sign(n[known]))
