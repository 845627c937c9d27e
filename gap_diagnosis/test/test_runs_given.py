"""Which runs and folders the command line takes; nothing is overwritten, nothing is counted twice."""

import numpy as np
import pytest

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.blind_check.store_io import write_generated_run
from gap_diagnosis.cli_check import main as check
from gap_diagnosis.cli_diagnose import main
from gap_diagnosis.recording_io import read_recordings, recordings_of
from run_bag import Topic, read_run, write_run
from thruster_model.errors import UnfitDataError
from thruster_model.parameter_set_io import load_parameter_set

CHANNELS = ("n", "ambient", "thrust", "torque")


@pytest.fixture
def write(tmp_path):
    def written(folder, name="dive", seed=1):
        truth = Truth(model="hl", parameters=dict(load_parameter_set("hl").values))
        throttle = np.repeat([0.0, 2.0, -2.0, 0.0], 50)
        (run,) = generate(truth, {name: throttle}, closed_loop=False, seed=seed)
        return write_generated_run(run, tmp_path / folder, CHANNELS)

    return written


@pytest.fixture
def refused(tmp_path, capsys):
    def run(*runs, model="hl"):
        assert main([*map(str, runs), "--model", model, "--out", str(tmp_path / "out")]) == 1
        return capsys.readouterr().err

    return run


def test_an_empty_folder_and_a_missing_one_are_both_named_before_anything_is_written(tmp_path, refused):
    (tmp_path / "empty").mkdir()
    said = refused(tmp_path / "empty", tmp_path / "lost")
    assert f"{tmp_path / 'empty'}: expected an .mcap file in it, found nothing" in said
    assert f"{tmp_path / 'lost'}: no such file or directory" in said
    assert not (tmp_path / "out").exists()


def test_an_unknown_model_is_refused_with_the_known_ones(write, refused):
    said = refused(write("runs"), model="nobody")
    assert "nobody: expected a YAML file or one of the known sets" in said and "simplified" in said


def test_another_thruster_than_the_recorded_one_is_refused_with_the_channels_that_there_are(tmp_path, write, capsys):
    options = ["--thruster", "3", "--out", str(tmp_path / "out")]
    assert main([str(write("runs")), "--model", "hl", *options]) == 1
    said = capsys.readouterr().err
    assert "dive: expected a channel thruster_3/throttle.commanded with values; found thruster_0/flow.ambient" in said


def test_a_folder_with_files_in_it_is_left_as_it_is(tmp_path, write, refused):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/diagnosis.json").write_text("{}")
    assert f"{tmp_path / 'out'}: expected a new or empty folder" in refused(write("runs"))
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["diagnosis.json"]
    assert (tmp_path / "out/diagnosis.json").read_text() == "{}"


def test_the_same_run_twice_is_refused_also_as_a_copy_elsewhere(tmp_path, write, refused):
    run, copy = write("runs"), write("copies", name="copied")
    assert f"{run}: given more than once; expected different runs" in refused(run, run)
    assert f"{copy}: holds the same samples as {run}; expected different runs" in refused(run, copy)
    assert not (tmp_path / "out").exists()


def test_different_runs_of_one_name_are_told_apart_by_their_folders(write):
    recordings = read_recordings([write("monday"), write("tuesday", seed=2)])
    assert [each.name for each in recordings] == ["monday/dive", "tuesday/dive"]


@pytest.fixture
def stating(tmp_path):
    """Return a function that writes a run with a missing command and metadata, and reads it back."""

    def read(metadata):
        time = 0.02 * np.arange(500)
        commands = 2.0 * np.sin(time)
        commands[100] = np.nan
        speed = 60.0 * np.sin(time) + np.random.default_rng(1).standard_normal(time.size)
        state = {"n": speed, "sign_source": np.ones(time.size)}
        topics = [Topic.of_thruster(0, "throttle", time, {"commanded": commands})]
        topics.append(Topic.of_thruster(0, "state", time, state))
        return recordings_of(read_run(write_run(tmp_path / "run", topics, metadata)))

    return read


@pytest.mark.parametrize(
    ("metadata", "said"),
    [
        ({"hold": {"throttle": "previous"}}, "the one before is held"),
        ({"hold": {"throttle": "linear"}}, "the line between those beside it is taken"),
        ({}, "those beside it tell what acts"),
    ],
)
def test_what_acts_where_a_command_is_missing_is_said_as_the_run_states_it(stating, metadata, said):
    (recording,) = stating(metadata)
    assert recording.experiment.warnings == (f"thruster_0/throttle.commanded: 1 of 500 stamps hold no command; {said}",)


@pytest.mark.parametrize("deviation", [1e5, -0.1, "late"])
def test_a_clock_that_may_be_off_by_more_than_the_run_lasts_is_refused(stating, deviation):
    expected = r"run: metadata clock_deviation.flow: expected seconds from 0 to the run's 10.0; found "
    with pytest.raises(UnfitDataError, match=expected):
        stating({"clock_deviation": {"flow": deviation}})


def test_clock_deviations_that_are_no_table_are_refused(stating):
    with pytest.raises(UnfitDataError, match=r"metadata clock_deviation: expected seconds .* found \[3\]"):
        stating({"clock_deviation": [3]})


def test_a_clock_deviation_within_the_run_is_taken(stating):
    (recording,) = stating({"clock_deviation": {"throttle": 0.02, "flow": None}})
    assert recording.experiment.throttle_shift_std == 0.02
    assert recording.experiment.measurements["speed"].shift_std == 0.0


def test_the_clock_of_a_speed_is_an_unknown_of_its_run_where_the_run_says_how_far_it_may_be_off(stating):
    (recording,) = stating({"clock_deviation": {"state": 0.03}})
    assert recording.experiment.measurements["speed"].shift_std == 0.03


@pytest.mark.parametrize("command", [main, check])
def test_runs_of_a_vehicle_are_taken_by_the_same_command(tmp_path, capsys, command):
    out = ["--out", str(tmp_path / "out")] if command is main else []
    assert command([str(tmp_path), "--vehicle", "no_such_vehicle", *out]) == 1
    assert "no_such_vehicle" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        command(["--help"])
    assert "--vehicle SET --help" in " ".join(capsys.readouterr().out.split())
