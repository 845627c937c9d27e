"""Pushes that move the rotor by far more than what its torque is read to: the filter's slopes are those of a secant."""

from dataclasses import replace

import numpy as np
import pytest

from gap_diagnosis import linear
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.recording_io import read_recordings
from gap_diagnosis.scoreboard.generators import GENERATORS
from gap_diagnosis.scoreboard.running_io import write_synthetic_run
from system_identification.learning import Caps, learned
from system_identification.noise import Whitener, whitener
from thruster_model.parameter_set_io import load_parameter_set


def problem_of(folder, effects, torque=1e-4) -> Problem:
    """Return two recordings by another simulator with these parameters, the rotor pushed by some rad/s.

    `torque`: to which it is read [N m].
    """
    lab = GENERATORS["lab"]
    drawn = lab.draw("none", 7, True)
    conditions = drawn.drawn._replace(
        runs=2, linear=False, told=True, tails=False, moving=False, outliers=0.0, varying=0.0, memory=3.0,
        push=(80.0, 0.0), rates=dict.fromkeys(drawn.drawn.rates, 50.0), phases=dict.fromkeys(drawn.drawn.phases, 0.0),
        noise={"speed": 1.0, "ambient": 0.005, "thrust": 0.3, "torque": torque},
    )  # fmt: skip
    same = dict.fromkeys(drawn.factors, 1.0)
    truth = replace(drawn, model="hl", factors=same, effects=effects, drawn=conditions)
    recordings = read_recordings([write_synthetic_run(run, folder) for run in lab.record(truth)])
    stated = load_parameter_set("hl")
    return Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated), fixed=effects)


@pytest.fixture(scope="module")
def pushed(tmp_path_factory) -> Problem:
    return problem_of(tmp_path_factory.mktemp("pushed"), {})


def learned_about(problem: Problem, base: Whitener) -> Whitener:
    return learned(base, problem.residuals(problem.start()), Caps(pushes=50.0), steps=15)


def test_a_torque_that_squares_what_pushes_do_is_no_trace_of_an_effect(pushed):
    half_way = whitener(pushed, pushed.start())
    about = replace(half_way, linear=pushed.linear(pushed.start()))
    found = learned_about(pushed, half_way).levels
    other = learned_about(pushed, about).levels
    assert found.colours["torque"] < 0.3 and found.colours["speed"] < 0.2
    assert other.colours["torque"] > 1.0 and other.colours["speed"] > 0.5


def test_a_level_says_by_how_many_readings_of_its_own_sensor_a_push_moves_the_rotor(pushed):
    found = learned_about(pushed, whitener(pushed, pushed.start())).levels
    still = np.sqrt(np.mean(pushed.residuals(pushed.start())[pushed.signal_rows["speed"]] ** 2))
    assert found.pushes[0] == pytest.approx(still / 1.0, rel=0.5)
    assert found.sensors["torque"] == pytest.approx(1e-4, rel=0.3)


def test_where_a_rotor_rests_between_two_thresholds_no_push_grows(pushed):
    held = replace(pushed, fixed={"start_hysteresis": {"voltage": 0.2}})
    for run in held.linear(held.start()):
        assert np.all(np.diagonal(run.transition, axis1=1, axis2=2) < 1.0 + 1e-9)
    assert whitener(held, held.start()).units == pytest.approx(whitener(pushed, pushed.start()).units, rel=0.5)


def test_where_pushes_reach_over_a_kink_its_mean_slope_is_likelier_than_that_of_either_side(tmp_path, monkeypatch):
    braked = problem_of(tmp_path, {"brake_asymmetry": {"share": -0.4, "onset": 0.2}}, torque=5e-4)

    def likelihood():
        found = learned_about(braked, whitener(braked, braked.start()))
        white = found.whiten(braked.residuals(braked.start()))
        return -0.5 * (float(white @ white) + found.log_det)

    mean = likelihood()
    monkeypatch.setattr(linear, "_SPREAD", 0.0)
    assert mean > likelihood() + 10.0


def test_what_rows_tell_does_not_jump_as_a_clock_moves_samples_past_an_instant_of_the_filter(pushed):
    def told(early: float) -> float:
        problem = replace(pushed, fixed={"log_alignment": {"load": early}})
        white = whitener(problem, problem.start()).whiten(problem.residuals(problem.start()))
        return float(white @ white)

    steps = [told(early) for early in np.linspace(0.0, 0.02, 41) + 1e-5]
    assert np.max(np.abs(np.diff(steps, 2))) < 0.2 * np.ptp(steps) / 40
