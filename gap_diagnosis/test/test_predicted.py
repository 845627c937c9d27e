"""A simulator's own predictions against a recording: known delays, gains and offsets are found, and where they are."""

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.cli_compare import compared, main
from gap_diagnosis.predicted import differences, throttle_apart
from gap_diagnosis.preparing import recording_of
from run_bag import Topic, read_run, write_run

TIME = 0.02 * np.arange(800)
THROTTLE = 2.5 * np.sign(np.sin(0.9 * TIME))
NOISE = 0.3


def speed(time, delay=0.0):
    """Return a smooth answer to a square wave [rad/s]; zero phase at the start."""
    return 100.0 * np.tanh(4.0 * np.sin(0.9 * (time - delay)))


def recording(values, throttle=THROTTLE, time=TIME):
    return recording_of("run", (TIME, throttle), {"speed": (time, values)})


@pytest.fixture(scope="module")
def measured():
    return recording(speed(TIME) + NOISE * np.random.default_rng(2).standard_normal(TIME.size))


def test_the_same_curve_differs_by_noise_alone(measured):
    (found,) = differences(measured, recording(speed(TIME)))
    assert not found.differs
    assert found.rms == pytest.approx(NOISE, rel=0.1)
    assert "no difference beyond the noise" in found.sentence


def test_a_delay_a_gain_and_an_offset_are_found(measured):
    (found,) = differences(measured, recording(0.8 * speed(TIME, delay=-0.1) + 5.0))
    assert found.differs
    assert found.lag == pytest.approx(0.1, abs=0.006)
    assert found.gain == pytest.approx(1.25, rel=0.01)
    assert found.left < 2.0 * NOISE < found.rms
    assert "0.1 s later, times 1.25" in found.sentence


def test_the_regime_in_which_only_reverse_is_wrong_is_reverse(measured):
    true = speed(TIME)
    (found,) = differences(measured, recording(np.where(true < 0.0, 0.9 * true, true)))
    assert found.by_regime["reverse"] > 10.0 * found.by_regime["forward"]
    assert found.mean == pytest.approx(float(np.mean(np.where(true < 0.0, 0.1 * true, 0.0))), abs=0.1)


def test_the_dead_zone_is_a_regime_only_where_its_edge_is_known():
    _, (run, *_) = campaign(runs=1, duration=10.0)
    without, with_edge = differences(run, run), differences(run, run, edge=0.8)
    assert "dead zone" not in without[0].by_regime and "dead zone" in with_edge[0].by_regime


def test_another_throttle_is_noticed(measured):
    assert throttle_apart(measured, recording(speed(TIME))) < 0.01
    assert throttle_apart(measured, recording(speed(TIME), throttle=0.5 * THROTTLE)) == pytest.approx(0.5, abs=0.02)


def write(path, values, *, begins=0.0, throttle=THROTTLE):
    topics = [
        Topic.of_thruster(0, "throttle", TIME + begins, {"commanded": throttle}),
        Topic.of_thruster(0, "state", TIME + begins, {"n": values, "sign_source": np.ones(TIME.size)}),
    ]
    write_run(path, topics, {})
    return path


def test_the_command_says_where_it_differs_and_what_it_cannot_say(tmp_path, capsys):
    noise = NOISE * np.random.default_rng(3).standard_normal(TIME.size)
    run = write(tmp_path / "run", speed(TIME) + noise)
    predicted = write(tmp_path / "predicted", speed(TIME, delay=-0.1))
    assert main([str(run), str(predicted)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("Rotor speed: ")
    assert "the prediction 0.1 s later" in said
    assert "What this cannot say: whether other parameters" in said


def test_runs_on_clocks_of_their_own_are_taken_to_begin_together_and_that_is_said(tmp_path):
    run = read_run(write(tmp_path / "run", speed(TIME)))
    apart = read_run(write(tmp_path / "apart", speed(TIME), begins=1000.0))
    told = compared(run, apart)
    assert told[0].startswith("note: the runs' stamps do not overlap")
    assert "no difference beyond the noise" in told[1]


def test_a_prediction_of_nothing_that_was_measured_is_refused(tmp_path, capsys):
    run = write(tmp_path / "run", speed(TIME))
    topics = [
        Topic.of_thruster(0, "throttle", TIME, {"commanded": THROTTLE}),
        Topic.of_thruster(0, "flow", TIME, {"ambient": 0.1 * np.sin(TIME)}),
    ]
    write_run(tmp_path / "flow", topics, {})
    assert main([str(run), str(tmp_path / "flow")]) == 1
    assert "flow: expected a signal that run has too, at the same time; found none" in capsys.readouterr().err
