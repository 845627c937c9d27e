"""One recording of a load cell that rests a little off zero: healthy; that was never tared: an effect."""

from dataclasses import replace

from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.recording_io import read_recordings
from gap_diagnosis.scoreboard.generators import GENERATORS
from gap_diagnosis.scoreboard.running_io import write_synthetic_run
from thruster_model.parameter_set_io import load_parameter_set


def bench(index):
    """Return a healthy bench of the scoreboard that is read at 200 Hz."""
    drawn = GENERATORS["propeller"].draw("none", index, True)
    return replace(drawn, drawn=drawn.drawn._replace(logger_rate=200.0))


def verdict_of_one(folder, truth, which, offset):
    """Return the verdict on one recording with a load cell that is off by so much [N]."""
    run = GENERATORS["propeller"].record(truth)[which]
    thrust = run.signals["thrust"]
    off = thrust._replace(values=thrust.values + offset)
    path = write_synthetic_run(replace(run, signals={**run.signals, "thrust": off}), folder)
    return diagnose(read_recordings([path]), load_parameter_set(truth.model)).verdict


def test_a_rest_value_of_one_recording_is_no_effect(tmp_path):
    truth = bench(61)
    assert verdict_of_one(tmp_path, truth, 1, -0.4 * truth.drawn.noise[2]).verdict in ("no_gap", "parameters")


def test_an_offset_of_one_recording_beyond_its_noise_is_one(tmp_path):
    truth = bench(50)
    offset = 4.0 * truth.drawn.noise[2]
    verdict = verdict_of_one(tmp_path, truth, 0, offset)
    (claim,) = verdict.claims
    assert (verdict.verdict, claim.effect) == ("effect", "load_cell_bias")
    size = claim.sizes["offset"]
    assert abs(size.value - offset) < 3.0 * size.std < offset
