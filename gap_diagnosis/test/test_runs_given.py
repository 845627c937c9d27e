"""Which runs and folders the command line takes; nothing is overwritten, nothing is counted twice."""

import numpy as np
import pytest

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.blind_check.store_io import write_generated_run
from gap_diagnosis.cli_diagnose import main
from gap_diagnosis.recording_io import read_recordings
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
